#include <fcntl.h>

#include "isolux/cli/run.h"

int main(int argc, char** argv) {
  // Where a standard stream is closed, the next file opened would take its number, and be written
  // to or closed as if it were that stream.
  int file = 0;
  while (file >= 0 && file <= 2) file = ::open("/dev/null", O_RDWR);
  return isolux::run({argv + 1, argv + argc});
}
