#include "isolux/bench/work.h"

#include <chrono>
#include <thread>

#include "isolux/bench/timing.h"

namespace isolux {
namespace {

// Worker threads look for more work for a moment before they sleep; they are not to do that in the
// other side's time.
double rested(const std::function<double(int)>& ms, int turn) {
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  return ms(turn);
}

void warm_up(const Work& work) {
  work.ms(work.turns);
  for (const Contestant& other : work.others) other.ms(work.turns);
}

}  // namespace

Measurement measure(const Work& work) {
  Measurement result{work.name, work.note, work.rays, {}, {}, -1};
  for (const Contestant& other : work.others) {
    result.comparisons.push_back({other.name, other.note, {}, {}});
  }
  warm_up(work);
  for (int turn = 0; turn < work.turns; ++turn) {
    if (work.others.empty()) result.ms.push_back(rested(work.ms, turn));
    for (std::size_t n = 0; n < work.others.size(); ++n) {
      if (turn % work.others[n].every != 0) continue;
      result.ms.push_back(rested(work.ms, turn));
      const double theirs = rested(work.others[n].ms, turn);
      result.comparisons[n].ms.push_back(theirs);
      result.comparisons[n].ratios.push_back(theirs / result.ms.back());
    }
  }
  result.load = load_average();
  return result;
}

}  // namespace isolux
