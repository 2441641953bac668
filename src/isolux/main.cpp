#include "isolux/cli/run.h"

int main(int argc, char** argv) { return isolux::run({argv + 1, argv + argc}); }
