// SPDX-License-Identifier: MIT
// A PNG as JPEG, for pictures that are too large otherwise: node as_jpeg.mjs FROM.png TO.jpg [QUALITY]
import { readFileSync, writeFileSync } from 'node:fs';
import jpeg from 'jpeg-js';
import { PNG } from 'pngjs';

const [from, to, quality = '88'] = process.argv.slice(2);
if (!to) throw new Error('usage: node as_jpeg.mjs FROM.png TO.jpg [QUALITY]');
writeFileSync(to, jpeg.encode(PNG.sync.read(readFileSync(from)), Number(quality)).data);
