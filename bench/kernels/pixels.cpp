#include <benchmark/benchmark.h>

#include "isolux/bench/limits.h"
#include "subject.h"

namespace isolux {
namespace {

constexpr int kSize = 256;

void light_and_display_a_buffer(benchmark::State& state) {
  OwnRenderer& head = head_of(kSize);
  for (auto turn : state) head.relight();
}
BENCHMARK(light_and_display_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

void display_a_buffer(benchmark::State& state) {
  OwnRenderer& head = head_of(kSize);
  for (auto turn : state) head.redisplay();
}
BENCHMARK(display_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

void stream_a_buffer(benchmark::State& state) {
  const OwnRenderer& head = head_of(kSize);
  RelightingLimit limit(head.surfaces(), head.hit_pixels());
  for (auto turn : state) limit.run();
}
BENCHMARK(stream_a_buffer)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isolux
