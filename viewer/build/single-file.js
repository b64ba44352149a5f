// SPDX-License-Identifier: MIT
// Vite plugins: everything into one HTML file that is a Mustache template.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";

/** The template's tags use <% and %>, since scripts are full of braces. */
const OPEN = "<%";
const SET_DELIMITERS = "{{=<% %>=}}";
/** What index.html and scene.html have in their policy in place of hashes. */
const HASH_OF_SCRIPT = "'hash-of-script'";
const HASH_OF_STYLE = "'hash-of-style'";
const TAGS = ["<% title %>", "<%& data %>"];

/** A script's text may not end its element, open a comment or look like a tag; in code all three occur in texts only. */
const safeScript = (code) =>
  code.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--").replaceAll(OPEN, "<\\x25");

/** A source for the content security policy: an element with exactly this text may run or apply. */
const hash = (text) => `'sha256-${createHash("sha256").update(text).digest("base64")}'`;

function holdsOnlyItsTags(html) {
  return html.split(OPEN).length - 1 === TAGS.length && TAGS.every((tag) => html.includes(tag));
}

/** Puts the one script and the one style sheet into the page, and names the page. */
export function singleFile(name) {
  return {
    name: "silvafit-single-file",
    apply: "build",
    enforce: "post",
    generateBundle(_, bundle) {
      const files = Object.values(bundle);
      const take = (suffix) => {
        const file = files.find((candidate) => candidate.fileName.endsWith(suffix));
        delete bundle[file.fileName];
        return String(file.code ?? file.source);
      };
      const script = `\n(() => {\n${safeScript(take(".js"))}\n})();\n`;
      const style = `\n${take(".css")}\n`;
      const html = take(".html")
        .replace(/\s*<script type="module"[^>]*><\/script>/, "")
        .replace(/\s*<link rel="stylesheet"[^>]*>/, "")
        .replace(HASH_OF_SCRIPT, () => hash(script))
        .replace(HASH_OF_STYLE, () => hash(style))
        .replace("</head>", () => `<style>${style}</style>\n</head>`)
        .replace("</body>", () => `<script>${script}</script>\n</body>`);
      if (!holdsOnlyItsTags(html)) this.error(`${name}: the page must hold exactly the tags ${TAGS.join(" and ")}`);
      if (/\bimport\s*\(|https?:[^"'\s]*\.(js|css|woff2?)\b/.test(html)) this.error(`${name}: the page must not fetch anything`);
      this.emitFile({ type: "asset", fileName: name, source: SET_DELIMITERS + html });
    },
  };
}

const POLICY = /<meta http-equiv="Content-Security-Policy"[^>]*>\n/;

/** While developing (`npm run dev`), the page shows an example, and may load its parts from the server. */
export function fillWithExample(path) {
  return {
    name: "silvafit-example",
    apply: "serve",
    transformIndexHtml: {
      order: "pre",
      handler: (html) =>
        html
          .replace(POLICY, "")
          .replace("<% title %>", "Example")
          .replace("<%& data %>", () => readFileSync(path, "utf8").replaceAll("<", "\\u003c")),
    },
  };
}
