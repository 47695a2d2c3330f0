// Runs Khronos' validator over GLB files: node validate_gltf.js NODE_MODULES FILE…. Prints what it finds, one line an issue.
const fs = require("fs");
const [modules, ...files] = process.argv.slice(2);
const validator = require(`${modules}/gltf-validator`);

// Blender's own file has a skinned mesh below its armature.
const options = { ignoredIssues: ["NODE_SKINNED_MESH_NON_ROOT"] };
const check = async (file) => {
  const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), options);
  for (const m of issues.messages.filter((m) => m.severity < 2)) console.log(`${file}: ${m.code} ${m.pointer}: ${m.message}`);
  return issues.numErrors + issues.numWarnings;
};
Promise.all(files.map(check)).then((found) => process.exit(found.some((n) => n > 0) ? 1 : 0));
