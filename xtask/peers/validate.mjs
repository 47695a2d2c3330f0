// Asks the Khronos glTF validator about each file named. Usage: node validate.mjs FILE...
// An error or a warning fails; hints and information, such as an unused UV set, are the artist's business.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(file)));
  console.log(`gltf-validator: ${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings`);
  if (issues.numErrors + issues.numWarnings > 0) {
    console.log(JSON.stringify(issues.messages.filter(({ severity }) => severity < 2), null, 2));
    process.exitCode = 1;
  }
}
