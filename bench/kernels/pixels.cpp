#include <benchmark/benchmark.h>

#include "isolux/bench/limits.h"
#include "subject.h"

namespace isolux {
namespace {

constexpr int kSize = 256;

void light_a_buffer(benchmark::State& state) {
  OwnRenderer& head = head_of(kSize);
  for (auto turn : state) head.relight();
}
BENCHMARK(light_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

void display_a_buffer(benchmark::State& state) {
  OwnRenderer& head = head_of(kSize);
  for (auto turn : state) head.show();
}
BENCHMARK(display_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

void stream_a_buffer(benchmark::State& state) {
  RelightingLimit limit(head_of(kSize).surfaces());
  for (auto turn : state) limit.run();
}
BENCHMARK(stream_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isolux
