// Runs Khronos' validator over GLB files; prints what it finds, one line an issue. Needs the npm package:
//     npm install --prefix target/validator gltf-validator@2.0.0-dev.3.10
// Exit codes: 0 clean, 1 errors or warnings, 3 the package is not there.
const fs = require("fs");
const path = require("path");

function load() {
  for (const name of ["gltf-validator", path.join(__dirname, "../target/validator/node_modules/gltf-validator")]) {
    try {
      return require(name);
    } catch (_) {}
  }
  console.error("gltf-validator is not installed");
  process.exit(3);
}

const validator = load();
const check = async (file) => {
  const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  for (const m of issues.messages.filter((m) => m.severity < 2)) console.log(`${file}: ${m.code} ${m.pointer}: ${m.message}`);
  return issues.numErrors + issues.numWarnings;
};
Promise.all(process.argv.slice(2).map(check)).then((found) => process.exit(found.some((n) => n > 0) ? 1 : 0));
