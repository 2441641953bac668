#include "isolux/io/dicom_signature.h"

#include <cstdint>
#include <string>

namespace isolux {
namespace {

std::uint32_t number_at(std::string_view bytes, std::size_t at, int width) {
  std::uint32_t number = 0;
  for (int n = width - 1; n >= 0; --n) {
    number = number << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(n)]);
  }
  return number;
}

// Value representations of short length, which is what a data set begins with.
bool is_short_vr(std::string_view vr) {
  constexpr std::string_view kShort =
      "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US ";
  return kShort.find(std::string(vr) + ' ') != std::string_view::npos;
}

// Whether two elements in ascending order stand at `at`, the first of group 2 or 8: little-endian,
// with or without value representations.
bool is_data_set(std::string_view bytes, std::size_t at) {
  std::uint32_t last_tag = 0;
  for (int element = 0; element < 2; ++element) {
    if (at + 8 > bytes.size()) return false;
    const std::uint32_t group = number_at(bytes, at, 2);
    const std::uint32_t tag = group << 16 | number_at(bytes, at + 2, 2);
    if (group != 2 && group != 8) return false;
    if (element > 0 && tag <= last_tag) return false;
    last_tag = tag;
    const bool is_explicit = is_short_vr(bytes.substr(at + 4, 2));
    const std::uint32_t length =
        is_explicit ? number_at(bytes, at + 6, 2) : number_at(bytes, at + 4, 4);
    if (length > bytes.size() || length % 2 != 0) return false;
    at += 8 + length;
  }
  return true;
}

}  // namespace

bool is_dicom_directory(std::string_view first_bytes) {
  // MediaStorageSOPClassUID, Media Storage Directory Storage
  constexpr std::string_view kMark(
      "\2\0\2\0UI\24\0"
      "1.2.840.10008.1.3.10",
      28);
  return first_bytes.size() >= 132 && first_bytes.substr(128, 4) == "DICM" &&
         first_bytes.find(kMark) != std::string_view::npos;
}

std::optional<std::size_t> dicom_start(std::string_view first_bytes) {
  if (first_bytes.size() >= 132 && first_bytes.substr(128, 4) == "DICM") {
    if (is_dicom_directory(first_bytes)) return std::nullopt;
    return 0;
  }
  // A stray byte before the data set is seen too (pydicom's no_meta.dcm).
  for (const std::size_t start : {0, 1}) {
    if (is_data_set(first_bytes, start)) return start;
  }
  return std::nullopt;
}

}  // namespace isolux
