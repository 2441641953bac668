#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace isolux {

/// Lets check_memory allow this many bytes; nothing: 80 % of the machine's memory, as from the
/// start.
void set_memory_limit(std::optional<double> bytes);

/// Whether the user has said how much it may be.
bool memory_limit_is_set();

/// "8G", "500M", "64k" (powers of 1000), "50%" of the machine's memory, or bytes; nothing where the
/// text is none of these.
std::optional<double> parse_memory(std::string_view text);

/// Asked before anything large is allocated.
/// @throws WorkError  where `bytes`, beside all that is held, exceed the limit; `what` needs them.
void check_memory(double bytes, const std::string& what);

/// Memory that is taken and counts in check_memory while this lives: what a volume's voxels hold.
class HeldMemory {
 public:
  explicit HeldMemory(std::size_t bytes);
  ~HeldMemory();
  HeldMemory(const HeldMemory&) = delete;
  HeldMemory& operator=(const HeldMemory&) = delete;

 private:
  std::size_t bytes_;
};

/// 14811136 -> "14.8 MB".
std::string bytes_text(double bytes);

}  // namespace isolux
