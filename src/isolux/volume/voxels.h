#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "isolux/base/mapped_file.h"
#include "isolux/base/memory.h"

namespace isolux {

/// Voxels in a row, to be read only. They lie in memory of their own or in a mapped file; copies
/// share it, and the last of them gives it back.
template <typename T>
class Voxels {
 public:
  using value_type = T;
  using const_iterator = const T*;

  Voxels() = default;

  /// Takes the values over. They count in check_memory as long as they are kept.
  Voxels(std::vector<T> values) {
    const auto owner = std::make_shared<const Heap>(std::move(values));
    first_ = owner->values.data();
    size_ = owner->values.size();
    owner_ = owner;
  }

  /// `count` voxels from byte `offset` of a file on, which is to be a multiple of sizeof(T).
  Voxels(std::shared_ptr<const MappedFile> file, std::size_t offset, std::size_t count)
      : first_(reinterpret_cast<const T*>(file->data() + offset)),
        size_(count),
        is_mapped_(true),
        owner_(std::move(file)) {}

  const T* data() const { return first_; }
  std::size_t size() const { return size_; }
  const T* begin() const { return first_; }
  const T* end() const { return first_ + size_; }
  const T& operator[](std::size_t n) const { return first_[n]; }
  bool is_mapped() const { return is_mapped_; }

  friend bool operator==(const Voxels& a, const Voxels& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  struct Heap {
    explicit Heap(std::vector<T> taken)
        : values(std::move(taken)), held(values.capacity() * sizeof(T)) {}
    std::vector<T> values;
    HeldMemory held;
  };

  const T* first_ = nullptr;
  std::size_t size_ = 0;
  bool is_mapped_ = false;
  std::shared_ptr<const void> owner_;
};

}  // namespace isolux
