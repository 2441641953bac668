// Several files as one: a tar archive, in the form that POSIX calls ustar. The files are not read
// here; the browser does that while it sends.

const block = 512;
const longestName = 100;

/** The end of a name holds its number and suffix, so a long one loses its beginning. */
function nameBytes(name: string): Uint8Array {
  const bytes = new TextEncoder().encode(name);
  let from = Math.max(0, bytes.length - longestName);
  while ((bytes[from] ?? 0) >> 6 === 2) from += 1; // not from the middle of a character
  return bytes.subarray(from);
}

function header(file: File): Uint8Array {
  const bytes = new Uint8Array(block);
  const put = (at: number, text: string) => bytes.set(new TextEncoder().encode(text), at);
  bytes.set(nameBytes(file.name), 0);
  put(100, '0000600\0'); // mode
  put(124, file.size.toString(8).padStart(11, '0') + '\0');
  put(136, '00000000000\0'); // time of change
  put(156, '0'); // a plain file
  put(257, 'ustar\x0000');
  put(148, ' '.repeat(8)); // the checksum counts itself as spaces
  const sum = bytes.reduce((all, one) => all + one, 0);
  put(148, sum.toString(8).padStart(6, '0') + '\0 ');
  return bytes;
}

export function packed(files: File[]): Blob {
  const parts: BlobPart[] = [];
  for (const file of files) {
    parts.push(header(file) as BlobPart, file, new Uint8Array((block - (file.size % block)) % block));
  }
  return new Blob([...parts, new Uint8Array(2 * block)]);
}
