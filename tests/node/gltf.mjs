// What the Khronos validator thinks of a glTF file: GLB on stdin, its report as JSON on stdout.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

const report = await validator.validateBytes(new Uint8Array(readFileSync(0)), { maxIssues: 20 });
process.stdout.write(JSON.stringify(report));
