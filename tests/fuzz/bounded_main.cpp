// Drives a fuzz target without libFuzzer: the seeds, then changed seeds, the same ones in every
// run, for a bounded number of inputs and seconds. `fuzz_nrrd [INPUTS [SECONDS]]`, or `fuzz_nrrd
// FILE` for a finding. The preset `fuzz` links the same targets with libFuzzer instead.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "fuzz/seeds.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace isolux::fuzz {
namespace {

class Mutator {
 public:
  std::string changed(std::string bytes) {
    for (std::size_t n = 0; n <= below(4); ++n) change_once(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t count) { return count == 0 ? 0 : random_() % count; }

  void change_once(std::string& bytes) {
    if (bytes.empty()) return;
    const std::size_t at = below(bytes.size());
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(random_());
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(32)));
        break;
      case 4:
        bytes.erase(at, below(16));
        break;
      default: {  // numbers at the edge, as text and as bytes
        static const std::string kEdges[] = {"0",
                                             "-1",
                                             "4294967295",
                                             "1e999",
                                             "nan",
                                             "999999999999",
                                             std::string(4, '\xff'),
                                             std::string("\0\0\0\x80", 4),
                                             std::string(2, '\0')};
        const std::string& edge = kEdges[below(std::size(kEdges))];
        bytes.replace(at, std::min(edge.size(), bytes.size() - at), edge);
      }
    }
  }

  std::mt19937_64 random_{20261122};
};

void run(const std::string& bytes, const std::string& kept) {
  std::ofstream(kept, std::ios::binary | std::ios::trunc) << bytes;  // what a crash leaves behind
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

}  // namespace
}  // namespace isolux::fuzz

int main(int argc, char** argv) {
  using namespace isolux::fuzz;
  const std::string kept = std::string(argv[0]) + ".last";
  if (argc > 1 && std::filesystem::is_regular_file(argv[1])) {
    std::ifstream file(argv[1], std::ios::binary);
    run({std::istreambuf_iterator<char>(file), {}}, kept);
    return 0;
  }
  const long inputs = argc > 1 ? std::atol(argv[1]) : 2000;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 4;
  const auto seeds = seeds_of(ISOLUX_FUZZ_FORMAT);
  const auto begin = std::chrono::steady_clock::now();
  Mutator mutator;
  long done = 0;
  for (const std::string& seed : seeds) run(seed, kept);
  for (; done < inputs; ++done) {
    run(mutator.changed(seeds[static_cast<std::size_t>(done) % seeds.size()]), kept);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
    if (taken.count() > seconds) break;
  }
  std::filesystem::remove(kept);
  std::printf("%s: %ld changed files, each read or refused\n", ISOLUX_FUZZ_FORMAT, done);
  return 0;
}
