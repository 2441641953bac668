#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace isolux {

/// Writes DICOM data sets in explicit VR little-endian, with a preamble; elements in ascending
/// order.
class DicomWriter {
 public:
  DicomWriter& text(int group, int element, const std::string& vr, std::string value) {
    if (value.size() % 2 != 0) value += vr == "UI" ? '\0' : ' ';
    return head(group, element, vr, value.size()).raw(value);
  }
  DicomWriter& us(int element, int value) { return head(0x28, element, "US", 2).number(value, 2); }
  DicomWriter& sequence(int group, int element, const std::vector<DicomWriter>& items) {
    std::string bytes;
    for (const DicomWriter& item : items) {
      DicomWriter head;
      head.number(0xfffe, 2).number(0xe000, 2).number(item.bytes_.size(), 4);
      bytes += head.bytes_ + item.bytes_;
    }
    return head(group, element, "SQ", bytes.size()).raw(bytes);
  }
  DicomWriter& pixels(const std::string& vr, int element, const std::string& bytes) {
    return head(0x7fe0, element, vr, bytes.size()).raw(bytes);
  }
  DicomWriter& pixels(const std::vector<std::uint16_t>& values) {
    head(0x7fe0, 0x10, "OW", 2 * values.size());
    for (const std::uint16_t value : values) number(value, 2);
    return *this;
  }
  /// Encoded pixels: an empty table of offsets, and a piece for each frame.
  DicomWriter& encoded(const std::vector<std::string>& pieces) {
    number(0x7fe0, 2).number(0x10, 2).raw("OB").number(0, 2).number(0xffffffff, 4);
    number(0xfffe, 2).number(0xe000, 2).number(0, 4);
    for (const std::string& piece : pieces) {
      number(0xfffe, 2).number(0xe000, 2).number(piece.size(), 4).raw(piece);
    }
    return number(0xfffe, 2).number(0xe0dd, 2).number(0, 4);
  }
  void write(const std::filesystem::path& path,
             const std::string& transfer_syntax = "1.2.840.10008.1.2.1") const {
    DicomWriter meta;
    meta.text(2, 0x10, "UI", transfer_syntax).raw(bytes_).write_bare(path);
  }
  /// Without a transfer syntax but what is in the elements.
  void write_bare(const std::filesystem::path& path) const {
    const std::string bytes = std::string(128, '\0') + "DICM" + bytes_;
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<long>(bytes.size()));
  }

 private:
  DicomWriter& raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  DicomWriter& number(std::uint64_t value, int width) {
    for (int n = 0; n < width; ++n) bytes_ += static_cast<char>(value >> (8 * n));
    return *this;
  }
  DicomWriter& head(int group, int element, const std::string& vr, std::size_t length) {
    number(static_cast<unsigned>(group), 2).number(static_cast<unsigned>(element), 2).raw(vr);
    if (vr == "OW" || vr == "SQ" || vr == "OF" || vr == "OD") return number(0, 2).number(length, 4);
    return number(length, 2);
  }

  std::string bytes_;
};

}  // namespace isolux
