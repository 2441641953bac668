#include "isolux/io/stored_bytes.h"

#include <archive.h>
#include <fcntl.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <vector>

#include "isolux/base/error.h"
#include "isolux/io/read_fenced.h"

namespace isolux {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPiece = 1 << 20;

WorkError damaged(const std::string& path, const char* why) {
  return {path, std::string("its compressed data are damaged: ") + (why ? why : "they end early"),
          "is the file complete?"};
}

std::ifstream opened(const StoredBytes& bytes) {
  errno = 0;
  std::ifstream file(bytes.path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(bytes.offset));
  if (!file) {
    throw WorkError(bytes.path, std::string("cannot be read: ") + std::strerror(errno),
                    "check its permissions");
  }
  return file;
}

// The bytes that StoredBytes stand for, from the first on.
class Source {
 public:
  virtual ~Source() = default;
  /// As many of `count` bytes (at most kPiece) as there are; 0 at the end only.
  virtual std::size_t read(char* to, std::size_t count) = 0;
  virtual void skip(std::uint64_t count) {
    std::vector<char> skipped(std::min<std::uint64_t>(count, kPiece));
    while (count > 0) {
      const std::size_t got = read(skipped.data(), std::min<std::uint64_t>(count, kPiece));
      if (got == 0) return;
      count -= got;
    }
  }
};

class Plain : public Source {
 public:
  explicit Plain(const StoredBytes& bytes) : path_(bytes.path), file_(opened(bytes)) {}

  std::size_t read(char* to, std::size_t count) override {
    file_.read(to, static_cast<std::streamsize>(count));
    if (file_.bad()) throw WorkError(path_, "cannot be read to its end", "check the disk");
    return static_cast<std::size_t>(file_.gcount());
  }
  void skip(std::uint64_t count) override {
    file_.seekg(static_cast<std::streamoff>(count), std::ios::cur);
  }

 private:
  std::string path_;
  std::ifstream file_;
};

// The inflated bytes of one or more zlib or gzip streams, one behind the other.
class Inflater : public Source {
 public:
  explicit Inflater(const StoredBytes& bytes)
      : path_(bytes.path), file_(opened(bytes)), buffer_(1 << 16) {
    constexpr int kZlibOrGzip = 15 + 32;
    if (inflateInit2(&stream_, kZlibOrGzip) != Z_OK) throw damaged(path_, stream_.msg);
  }
  ~Inflater() override { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  std::size_t read(char* to, std::size_t count) override {
    stream_.next_out = reinterpret_cast<Bytef*>(to);
    stream_.avail_out = static_cast<uInt>(count);
    while (stream_.avail_out > 0 && more_input()) {
      const int status = inflate(&stream_, Z_NO_FLUSH);
      if (status == Z_STREAM_END) {
        at_stream_end_ = true;
      } else if (status != Z_OK && status != Z_BUF_ERROR) {
        throw damaged(path_, stream_.msg);
      }
    }
    return count - stream_.avail_out;
  }

 private:
  // Whether there is a byte to inflate. Behind the end of a stream only another gzip stream counts;
  // anything else there is padding.
  bool more_input() {
    if (stream_.avail_in == 0) {
      file_.read(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
      if (file_.bad()) throw WorkError(path_, "cannot be read to its end", "check the disk");
      stream_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
      stream_.avail_in = static_cast<uInt>(file_.gcount());
    }
    if (stream_.avail_in == 0) return false;
    if (!at_stream_end_) return true;
    constexpr Bytef kGzipMark = 0x1f;
    if (*stream_.next_in != kGzipMark) return false;
    at_stream_end_ = false;
    return inflateReset(&stream_) == Z_OK;
  }

  std::string path_;
  std::ifstream file_;
  std::vector<char> buffer_;
  z_stream stream_{};
  bool at_stream_end_ = false;
};

// Sends the unpacked bytes of a bzip2 stream in pieces, each with its length before it, and a
// length of 0 at the end.
void send_unpacked(const StoredBytes& bytes, FenceOutput& output) {
  const int file = ::open(bytes.path.c_str(), O_RDONLY | O_CLOEXEC);
  const std::unique_ptr<archive, decltype(&archive_read_free)> stream(archive_read_new(),
                                                                      archive_read_free);
  archive_read_support_filter_bzip2(stream.get());
  archive_read_support_format_raw(stream.get());
  archive_entry* entry = nullptr;
  if (file < 0 || ::lseek(file, static_cast<off_t>(bytes.offset), SEEK_SET) < 0 ||
      archive_read_open_fd(stream.get(), file, kPiece) != ARCHIVE_OK ||
      archive_read_next_header(stream.get(), &entry) != ARCHIVE_OK ||
      archive_filter_code(stream.get(), 0) != ARCHIVE_FILTER_BZIP2) {
    throw damaged(bytes.path, "they are not bzip2");
  }
  std::vector<char> piece(kPiece);
  la_ssize_t got = 0;
  do {
    got = archive_read_data(stream.get(), piece.data(), piece.size());
    if (got < 0) throw damaged(bytes.path, archive_error_string(stream.get()));
    const std::uint64_t length = static_cast<std::uint64_t>(got);
    output.send(&length, sizeof length);
    output.send(piece.data(), static_cast<std::size_t>(got));
  } while (got > 0);
}

// The unpacked bytes of a bzip2 stream, by libarchive inside a fence.
class Bunzipper : public Source {
 public:
  explicit Bunzipper(const StoredBytes& bytes)
      : next_(read_fenced(bytes.path, 0,
                          [&](FenceOutput& output) { send_unpacked(bytes, output); })) {}

  std::size_t read(char* to, std::size_t count) override {
    if (left_ == 0 && !at_end_) next_(reinterpret_cast<char*>(&left_), sizeof left_);
    at_end_ = left_ == 0;
    const auto taken = static_cast<std::size_t>(std::min<std::uint64_t>(left_, count));
    next_(to, taken);
    left_ -= taken;
    return taken;
  }

 private:
  std::function<void(char*, std::size_t)> next_;
  std::uint64_t left_ = 0;
  bool at_end_ = false;
};

std::unique_ptr<Source> source_of(const StoredBytes& bytes) {
  if (bytes.deflated) return std::make_unique<Inflater>(bytes);
  if (bytes.bzip2) return std::make_unique<Bunzipper>(bytes);
  return std::make_unique<Plain>(bytes);
}

// As many of `count` bytes as there are.
std::size_t read_all(Source& source, char* to, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const std::size_t got = source.read(to + done, std::min(kPiece, count - done));
    if (got == 0) break;
    done += got;
  }
  return done;
}

WorkError too_short(const Stretch& stretch, std::uint64_t got) {
  return {stretch.file.path,
          "ends too early: " + std::to_string(got) + " of " + std::to_string(stretch.bytes) +
              " bytes of voxels are there",
          "is the file complete?"};
}

void check_holds(const Stretch& stretch) {
  std::vector<char> piece(kPiece);
  const std::unique_ptr<Source> source = source_of(stretch.file);
  std::uint64_t missing = stretch.skip + stretch.bytes;
  while (missing > 0) {
    const std::size_t got = source->read(piece.data(), std::min<std::uint64_t>(missing, kPiece));
    if (got == 0) throw too_short(stretch, stretch.bytes - std::min(missing, stretch.bytes));
    missing -= got;
  }
}

std::uint64_t bytes_of(const std::vector<Stretch>& stretches) {
  std::uint64_t bytes = 0;
  for (const Stretch& stretch : stretches) bytes += stretch.bytes;
  return bytes;
}

}  // namespace

std::size_t read_bytes(const StoredBytes& from, std::uint64_t skip, char* to, std::size_t count) {
  const std::unique_ptr<Source> source = source_of(from);
  source->skip(skip);
  return read_all(*source, to, count);
}

void check_large_stretches(const std::vector<Stretch>& stretches) {
  constexpr std::uint64_t kLarge = 1'000'000'000;
  if (bytes_of(stretches) < kLarge) return;
  for (const Stretch& stretch : stretches) {
    if (stretch.file.deflated || stretch.file.bzip2) check_holds(stretch);
  }
}

struct StretchReader::State {
  State(std::vector<Stretch> list, const ProgressListener& told)
      : stretches(std::move(list)),
        listener(told),
        progress(listener, "reading", bytes_of(stretches)) {}

  std::vector<Stretch> stretches;
  ProgressListener listener;
  Progress progress;
  std::size_t at = 0;              // which of the stretches
  std::uint64_t done = 0;          // how many of its bytes
  std::unique_ptr<Source> source;  // open where one is begun
};

StretchReader::StretchReader(std::vector<Stretch> stretches, const ProgressListener& listener)
    : state_(std::make_unique<State>(std::move(stretches), listener)) {}

StretchReader::~StretchReader() = default;
StretchReader::StretchReader(StretchReader&&) noexcept = default;

void StretchReader::read(char* to, std::size_t count) {
  State& s = *state_;
  while (count > 0) {
    const Stretch& stretch = s.stretches.at(s.at);
    if (!s.source) {
      s.source = source_of(stretch.file);
      s.source->skip(stretch.skip);
      s.done = 0;
    }
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>({count, stretch.bytes - s.done, kPiece}));
    const std::size_t got = s.source->read(to, wanted);
    if (got == 0) throw too_short(stretch, s.done);
    to += got;
    count -= got;
    s.done += got;
    s.progress.advance(got);
    if (s.done < stretch.bytes) continue;
    // One byte further, so that the checksum at the end of a compressed stream is looked at.
    char beyond = 0;
    if (stretch.file.deflated || stretch.file.bzip2) s.source->read(&beyond, 1);
    s.source.reset();
    ++s.at;
  }
}

std::string first_bytes(const StoredBytes& from, std::size_t count) {
  std::string bytes(count, '\0');
  bytes.resize(read_bytes(from, 0, bytes.data(), count));
  return bytes;
}

double stored_size(const StoredBytes& from) {
  std::error_code error;
  const double size = static_cast<double>(fs::file_size(from.path, error));
  if (error) {
    throw WorkError(from.path, "cannot be read: " + error.message(),
                    "a header needs its data files beside or below it");
  }
  return std::max(0.0, size - static_cast<double>(from.offset));
}

}  // namespace isolux
