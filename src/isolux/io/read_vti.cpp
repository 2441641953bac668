#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

#include "isolux/base/error.h"
#include "isolux/io/channels.h"
#include "isolux/io/format.h"
#include "isolux/io/number_text_file.h"
#include "isolux/io/vti_header.h"

// VTK's XML image files: a header in XML, and an array of values in it or behind it, as text,
// base64 or raw, perhaps deflated in blocks.

namespace isolux {
namespace {

WorkError damaged(const std::string& path, const std::string& why) {
  return {path, "its array is damaged: " + why, "is the file complete?"};
}

// The bytes of the array as they were before base64.
class ArrayBytes {
 public:
  ArrayBytes(const std::string& path, const VtiHeader& header)
      : path_(path),
        at_(header.data_offset),
        end_(header.data_end),
        is_base64_(header.encoding == VtiEncoding::kBase64) {}

  void read(char* to, std::size_t count) {
    for (std::size_t done = 0; done < count;) {
      if (next_ == bytes_.size()) refill();
      const std::size_t taken = std::min(count - done, bytes_.size() - next_);
      std::memcpy(to + done, bytes_.data() + next_, taken);
      next_ += taken;
      done += taken;
    }
  }

 private:
  void refill() {
    constexpr std::size_t kPiece = 1 << 18;
    bytes_.clear();
    next_ = 0;
    while (bytes_.empty()) {
      const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(kPiece, end_ - at_));
      const std::string piece = first_bytes({path_, at_}, wanted);
      if (piece.empty()) throw damaged(path_, "it ends too early");
      at_ += piece.size();
      if (!is_base64_) {
        bytes_ = piece;
        return;
      }
      for (const char c : piece) take_digit(c);
    }
  }

  // Header and data may be encoded apart: behind padding, base64 begins anew.
  void take_digit(char c) {
    static const std::string kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (c == ' ' || (c >= '\t' && c <= '\r')) return;
    if (c == '=') {
      bits_ = 0;
      bit_count_ = 0;
      return;
    }
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string::npos) {
      end_ = at_;  // behind appended data comes </AppendedData>
      return;
    }
    bits_ = bits_ << 6 | static_cast<unsigned>(digit);
    bit_count_ += 6;
    if (bit_count_ < 8) return;
    bit_count_ -= 8;
    bytes_ += static_cast<char>(bits_ >> bit_count_ & 0xff);
  }

  std::string path_;
  std::uint64_t at_, end_;
  bool is_base64_;
  unsigned bits_ = 0;
  int bit_count_ = 0;
  std::string bytes_;
  std::size_t next_ = 0;
};

// The array's values one behind the other, inflated.
class ArrayValues {
 public:
  ArrayValues(const std::string& path, const VtiHeader& header, std::uint64_t bytes)
      : path_(path), header_(header), source_(path, header) {
    if (!header.deflated) {
      check_size(number());
      return;
    }
    const std::uint64_t count = number(), block = number(), last = number();
    constexpr std::uint64_t kLargestBlock = 1 << 28;
    const std::uint64_t whole = last == 0 ? count : count - 1;
    if (count == 0 || block == 0 || block > kLargestBlock || last > block || count > bytes) {
      throw damaged(path_, "its blocks make no sense");
    }
    check_size(whole * block + last);
    for (std::uint64_t n = 0; n < count; ++n) packed_sizes_.push_back(number());
    block_ = block;
  }

  void read(char* to, std::size_t count) {
    if (!header_.deflated) {
      source_.read(to, count);
      return;
    }
    for (std::size_t done = 0; done < count;) {
      if (next_ == values_.size()) inflate_block();
      const std::size_t taken = std::min(count - done, values_.size() - next_);
      std::memcpy(to + done, values_.data() + next_, taken);
      next_ += taken;
      done += taken;
    }
  }

 private:
  std::uint64_t number() {
    unsigned char bytes[8] = {};
    source_.read(reinterpret_cast<char*>(bytes), static_cast<std::size_t>(header_.header_bytes));
    std::uint64_t value = 0;
    for (int n = 0; n < header_.header_bytes; ++n) {
      value = value << 8 | bytes[header_.big_endian ? n : header_.header_bytes - 1 - n];
    }
    return value;
  }

  void check_size(std::uint64_t found) const {
    const double wanted = static_cast<double>(bytes_of(header_.type)) * header_.number_count();
    if (static_cast<double>(found) != wanted) {
      throw damaged(path_, "it holds " + std::to_string(found) + " bytes, not those of its grid");
    }
  }

  void inflate_block() {
    if (block_number_ == packed_sizes_.size()) throw damaged(path_, "it ends too early");
    const std::uint64_t packed_size = packed_sizes_[block_number_++];
    if (packed_size > compressBound(static_cast<uLong>(block_))) {
      throw damaged(path_, "a block is longer than what it packs");
    }
    packed_.resize(packed_size);
    source_.read(packed_.data(), packed_.size());
    values_.resize(block_);
    uLongf size = static_cast<uLongf>(block_);
    if (uncompress(reinterpret_cast<Bytef*>(values_.data()), &size,
                   reinterpret_cast<const Bytef*>(packed_.data()),
                   static_cast<uLong>(packed_.size())) != Z_OK ||
        size == 0) {
      throw damaged(path_, "a block cannot be inflated");
    }
    values_.resize(size);
    next_ = 0;
  }

  std::string path_;
  VtiHeader header_;
  ArrayBytes source_;
  std::vector<std::uint64_t> packed_sizes_;
  std::uint64_t block_ = 0;
  std::size_t block_number_ = 0;
  std::string packed_, values_;
  std::size_t next_ = 0;
};

bool recognises(const ReadRequest&, std::string_view first_bytes) {
  return first_bytes.find("<VTKFile") != std::string_view::npos;
}

// Called before anything is allocated.
void check_promise_of(const std::string& path, const VtiHeader& header) {
  const auto available = static_cast<double>(header.data_end - header.data_offset);
  const double bytes = header.number_count() * static_cast<double>(bytes_of(header.type));
  if (header.encoding == VtiEncoding::kText) {
    check_promise(path, 2 * header.number_count() - 1, available, "raw");  // a digit and a blank
  } else {
    const double packed = header.encoding == VtiEncoding::kBase64 ? 0.75 * available : available;
    check_promise(path, bytes, packed, header.deflated ? "zlib" : "raw");
  }
}

OpenedInput open(const ReadRequest& request) {
  const VtiHeader header = read_vti_header(request.name);
  check_promise_of(request.name, header);
  OpenedInput opened;
  opened.result.format = "VTK image";
  opened.result.files = {request.name};
  opened.result.notes = header.notes;
  opened.volume.dims = header.dims;
  opened.volume.world_from_index = header.world_from_index;
  const auto [channels, volume] =
      choose_channel(request, header.type, header.channels, header.channels > 1, 1, opened.result);
  const auto numbers = static_cast<std::uint64_t>(header.number_count());
  const std::uint64_t count = numbers / static_cast<std::uint64_t>(header.channels);
  const std::uint64_t bytes = numbers * bytes_of(header.type);
  constexpr bool kThisMachineIsBig = std::endian::native == std::endian::big;
  const bool is_text = header.encoding == VtiEncoding::kText;
  const bool swapped = !is_text && header.big_endian != kThisMachineIsBig;
  if (header.encoding == VtiEncoding::kRaw && !header.deflated) {
    ArrayValues(request.name, header, bytes);  // looks at the size before the values
    const std::uint64_t skip = static_cast<std::uint64_t>(header.header_bytes);
    plan_voxels(opened, request, header.type, swapped, {},
                {{{request.name, header.data_offset}, skip, bytes}}, channels);
    return opened;
  }
  opened.stored_type = name_of(header.type);
  opened.bytes_per_voxel_most = bytes_per_voxel_most(header.type, {});
  opened.read_voxels = [=, channels = channels](std::vector<std::string>& notes) {
    Progress progress(request.listener, "reading", bytes);
    const auto from_the_first = [&]() -> ReadNext {
      if (is_text) {
        const Stretch text{
            {request.name, header.data_offset}, 0, header.data_end - header.data_offset};
        return one_a_voxel(read_number_text({text}, header.type), header.type, channels);
      }
      const auto values = std::make_shared<ArrayValues>(request.name, header, bytes);
      const auto next = [&, values](char* to, std::size_t wanted) {
        values->read(to, wanted);
        progress.advance(wanted);
      };
      return one_a_voxel(next, header.type, channels);
    };
    return voxels_read(request.name, header.type, count, swapped, {}, from_the_first, notes);
  };
  return opened;
}

}  // namespace

Format vti_format() { return {recognises, open}; }

}  // namespace isolux
