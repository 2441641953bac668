#include <benchmark/benchmark.h>

#include "isolux/bench/loose_rays.h"
#include "isolux/bench/ray_sets.h"
#include "subject.h"

namespace isolux {
namespace {

void first_hit_of_incoherent_rays(benchmark::State& state) {
  const OwnRenderer& head = head_of(static_cast<int>(state.range(0)));
  const LooseRays tracer(head.scene().surfaces[0]);
  const std::vector<Ray> rays = cosine_rays(*head.scene().camera, head.surfaces());
  for (auto turn : state) benchmark::DoNotOptimize(tracer.count_hits(rays));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}
BENCHMARK(first_hit_of_incoherent_rays)
    ->Arg(128)
    ->Arg(256)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void trace_a_picture(benchmark::State& state) {
  OwnRenderer& head = head_of(static_cast<int>(state.range(0)));
  for (auto turn : state) head.trace();
}
BENCHMARK(trace_a_picture)->Arg(128)->Arg(256)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isolux
