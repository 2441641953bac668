#include "isolux/io/number_text_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <utility>

#include "isolux/base/error.h"

namespace isolux {
namespace {

bool is_between(char c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == ','; }

// The characters of several stretches, with a blank behind each.
class Characters {
 public:
  explicit Characters(std::vector<Stretch> stretches) : stretches_(std::move(stretches)) {}

  /// The next one, or -1 at the end.
  int next() {
    if (at_ == piece_.size() && !refill()) return -1;
    return static_cast<unsigned char>(piece_[at_++]);
  }

  const std::string& path() const {
    return stretches_[std::min(number_, stretches_.size() - 1)].file.path;
  }

 private:
  bool refill() {
    if (number_ == stretches_.size()) return false;
    constexpr std::uint64_t kPiece = 1 << 16;
    Stretch& stretch = stretches_[number_];
    piece_ = first_bytes(stretch.file, std::min(kPiece, stretch.bytes));
    stretch.file.offset += piece_.size();
    stretch.bytes -= piece_.size();
    if (piece_.empty()) {
      piece_ = " ";
      ++number_;
    }
    at_ = 0;
    return true;
  }

  std::vector<Stretch> stretches_;
  std::size_t number_ = 0;  // of the stretch that is read
  std::string piece_;
  std::size_t at_ = 0;
};

// The next word, which is empty at the end.
std::string next_word(Characters& characters) {
  constexpr std::size_t kLongest = 400;
  std::string word;
  int c = characters.next();
  while (c >= 0 && is_between(static_cast<char>(c))) c = characters.next();
  for (; c >= 0 && !is_between(static_cast<char>(c)) && word.size() < kLongest;
       c = characters.next()) {
    word += static_cast<char>(c);
  }
  return word;
}

template <typename Number>
Number parse(const std::string& word, const std::string& path) {
  const std::size_t sign = word.starts_with('+') ? 1 : 0;
  Number number{};
  const char* const end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data() + sign, end, number);
  if (parsed.ec == std::errc{} && parsed.ptr == end && !word.empty()) return number;
  if (word.empty()) {
    throw WorkError(path, "ends too early: numbers are missing", "is the file complete?");
  }
  throw WorkError(path, "holds '" + word.substr(0, 40) + "', which is no number of its type",
                  "mend it, or its header");
}

int hex_digit(int c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

int next_hex_digit(Characters& characters) {
  int c = characters.next();
  while (c >= 0 && is_between(static_cast<char>(c))) c = characters.next();
  const int digit = hex_digit(c);
  if (digit >= 0) return digit;
  throw WorkError(
      characters.path(),
      c < 0 ? "ends too early: digits are missing" : "holds what is no hexadecimal digit",
      "is the file complete?");
}

}  // namespace

ReadNext read_number_text(std::vector<Stretch> stretches, StoredType type) {
  const auto characters = std::make_shared<Characters>(std::move(stretches));
  return with_type(type, [&]<typename Number>(Number) -> ReadNext {
    return [characters](char* to, std::size_t bytes) {
      for (std::size_t n = 0; n < bytes; n += sizeof(Number)) {
        const auto number = parse<Number>(next_word(*characters), characters->path());
        std::memcpy(to + n, &number, sizeof number);
      }
    };
  });
}

ReadNext read_hex_text(std::vector<Stretch> stretches) {
  const auto characters = std::make_shared<Characters>(std::move(stretches));
  return [characters](char* to, std::size_t bytes) {
    for (std::size_t n = 0; n < bytes; ++n) {
      const int high = next_hex_digit(*characters);
      to[n] = static_cast<char>(high << 4 | next_hex_digit(*characters));
    }
  };
}

}  // namespace isolux
