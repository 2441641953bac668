#pragma once

#include <cstddef>
#include <functional>

namespace isolux {

/// Runs `work` so that every parallel_for inside it uses `threads` threads (0: all cores).
void with_threads(int threads, const std::function<void()>& work);

/// Calls `body(begin, end)` for consecutive pieces of [0, count) of at most `grain` items, on the
/// threads of the innermost with_threads. Which thread gets which piece is not fixed, so a body
/// writes only what belongs to its own items. The first exception thrown inside is thrown here.
void parallel_for(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace isolux
