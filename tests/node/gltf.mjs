// What the Khronos validator has against a binary glTF file on stdin: a JSON list of its errors and warnings.
import { readFileSync } from "node:fs";
import validator from "gltf-validator";

const report = await validator.validateBytes(new Uint8Array(readFileSync(0)), { maxIssues: 20 });
const grave = report.issues.messages.filter(issue => issue.severity <= 1);
process.stdout.write(JSON.stringify(grave.map(issue => `${issue.code} at ${issue.pointer}: ${issue.message}`)));
