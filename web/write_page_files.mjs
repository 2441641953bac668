// Makes C++ of what Vite has made: the page's files, compressed, inside the program.
//   node write_page_files.mjs DIST OUT.cpp
import { existsSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join, posix } from 'node:path';
import { gzipSync } from 'node:zlib';

const types = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.svg': 'image/svg+xml',
  '.woff2': 'font/woff2',
};

function filesBelow(folder, path = '/') {
  return readdirSync(folder, { withFileTypes: true })
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) =>
      entry.isDirectory()
        ? filesBelow(join(folder, entry.name), posix.join(path, entry.name))
        : [{ path: posix.join(path, entry.name), file: join(folder, entry.name) }],
    );
}

// Octal escapes end by themselves after three digits, whatever follows.
function literal(bytes) {
  let text = '';
  for (let at = 0; at < bytes.length; at += 24) {
    const line = bytes.subarray(at, at + 24);
    text += '\n    "' + Array.from(line, (b) => '\\' + b.toString(8).padStart(3, '0')).join('') + '"';
  }
  return text;
}

const [dist, out] = process.argv.slice(2);
const rows = filesBelow(dist).map(({ path, file }) => {
  const type = types[extname(file)];
  if (!type) throw new Error(`${file}: no content type is known for it`);
  const bytes = gzipSync(readFileSync(file), { level: 9 });
  const shown = path === '/index.html' ? '/' : path;
  return `    {"${shown}", "${type}", std::string_view(${literal(bytes)}, ${bytes.length})},\n`;
});
const source = `// Made by web/write_page_files.mjs.
#include "isolux/server/page_files.h"

namespace isolux {
namespace {

constexpr PageFile kFiles[] = {
${rows.join('')}};

}  // namespace

const PageFile* find_page_file(std::string_view path) {
  for (const PageFile& file : kFiles) {
    if (file.path == path) return &file;
  }
  return nullptr;
}

bool has_page() { return true; }

}  // namespace isolux
`;
if (!existsSync(out) || readFileSync(out, 'utf8') !== source) writeFileSync(out, source);
