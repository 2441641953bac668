// node run.mjs TEST.mjs: one file of tests, with what it needs from npm; exit 77 (skipped) without a
// browser, or where npm cannot bring the rest.
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));

const skip = (why) => {
  console.log('skipped: ' + why);
  process.exit(77);
};

const lock = readFileSync(join(here, 'package-lock.json'), 'utf8');
const mark = join(here, 'node_modules/.isolux-lock');
if (!existsSync(mark) || readFileSync(mark, 'utf8') !== lock) {
  const options = ['ci', '--ignore-scripts', '--no-audit', '--no-fund', '--fetch-retries=1'];
  const npm = spawnSync('npm', options, { cwd: here, encoding: 'utf8' });
  if (npm.status !== 0) skip('npm could not fetch playwright-core and axe-core: ' + npm.stderr);
  writeFileSync(mark, lock);
}
if (spawnSync('chromium', ['--version']).status !== 0) skip('there is no chromium');

// Run as a program, not by `node --test`, the process can be made to end with its last test.
const test = spawnSync(process.execPath, ['--test-reporter=spec', process.argv[2]], {
  stdio: 'inherit',
});
process.exit(test.status ?? 1);
