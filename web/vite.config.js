import { defineConfig } from 'vite';

// KaTeX names each font in three forms; every browser that runs the page reads the first.
const onlyWoff2 = {
  name: 'only-woff2',
  enforce: 'pre',
  transform: (code, id) =>
    id.endsWith('katex.min.css') ? code.replace(/,url\([^)]*\.(?:woff|ttf)\) format\("[^"]*"\)/g, '') : null,
};

export default defineConfig({
  plugins: [onlyWoff2],
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  // No file inside another: the content policy of the page allows no inline parts.
  build: { assetsInlineLimit: 0, modulePreload: { polyfill: false }, target: 'es2022' },
});
