#include <benchmark/benchmark.h>

#include "isolux/bench/limits.h"
#include "isolux/volume/brick_grid.h"
#include "subject.h"

namespace isolux {
namespace {

const Volume& volume_of(const benchmark::State& state) {
  return *head_of(static_cast<int>(state.range(0))).scene().surfaces[0].volume;
}

void set_bytes(benchmark::State& state) {
  state.SetBytesProcessed(state.iterations() *
                          static_cast<std::int64_t>(voxel_bytes(volume_of(state))));
}

void build_bricks(benchmark::State& state) {
  const Volume& volume = volume_of(state);
  for (auto turn : state) benchmark::DoNotOptimize(BrickGrid(volume));
  set_bytes(state);
}
BENCHMARK(build_bricks)->Arg(128)->Arg(256)->UseRealTime()->Unit(benchmark::kMillisecond);

void read_every_voxel(benchmark::State& state) {
  const Volume& volume = volume_of(state);
  for (auto turn : state) benchmark::DoNotOptimize(read_voxels_once(volume));
  set_bytes(state);
}
BENCHMARK(read_every_voxel)->Arg(128)->Arg(256)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isolux
