// SPDX-License-Identifier: MIT
// Validates GLB and glTF files: node validate.mjs FILE ...; any error or warning fails.
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import validator from 'gltf-validator';

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node validate.mjs FILE.glb ...');
  process.exit(2);
}

let failed = false;
for (const file of files) {
  const beside = async (uri) =>
    new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri))));
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)),
                                               { uri: file, externalResourceFunction: beside });
  const { numErrors, numWarnings, messages } = report.issues;
  console.log(`${file}: ${report.info.totalTriangleCount} triangles, ` +
              `${numErrors} errors, ${numWarnings} warnings`);
  for (const message of messages) {
    console.log(`  ${message.code} ${message.pointer ?? ''}: ${message.message}`);
  }
  failed ||= numErrors > 0 || numWarnings > 0;
}
process.exit(failed ? 1 : 0);
