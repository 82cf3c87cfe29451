// Reads GLB files with gltf-validator.
//
// usage: node check_glb.mjs FILE...
// Prints one JSON line for each file; exits 1 where one has an error or a warning.
import fs from "node:fs";
import validator from "gltf-validator";

for (const file of process.argv.slice(2)) {
  const { issues, info } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  console.log(JSON.stringify({ file: file.split("/").pop(), errors: issues.numErrors, warnings: issues.numWarnings,
                               vertices: info.totalVertexCount, triangles: info.totalTriangleCount,
                               images: info.resources.filter((r) => r.image).length, messages: issues.messages.slice(0, 5) }));
  if (issues.numErrors + issues.numWarnings > 0) process.exitCode = 1;
}
