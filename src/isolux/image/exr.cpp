#include "isolux/image/exr.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>

#include <cstring>

#include "isolux/base/error.h"

namespace isolux {
namespace {

class MemoryOutput : public Imf::OStream {
 public:
  explicit MemoryOutput(std::string& bytes) : OStream("memory"), bytes_(bytes) {}
  void write(const char* from, int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ + size > bytes_.size()) bytes_.resize(at_ + size);
    std::memcpy(bytes_.data() + at_, from, size);
    at_ += size;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t position) override { at_ = position; }

 private:
  std::string& bytes_;
  std::size_t at_ = 0;
};

class MemoryInput : public Imf::IStream {
 public:
  explicit MemoryInput(std::string_view bytes) : IStream("memory"), bytes_(bytes) {}
  bool read(char* to, int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (at_ > bytes_.size() || size > bytes_.size() - at_) {
      throw std::runtime_error("the file ends too early");
    }
    std::memcpy(to, bytes_.data() + at_, size);
    at_ += size;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

Imf::FrameBuffer frame_buffer(Layers& layers) {
  Imf::FrameBuffer buffer;
  for (Layers::Channel& channel : layers.channels) {
    buffer.insert(
        channel.name,
        Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(channel.values.data()), sizeof(float),
                   sizeof(float) * static_cast<std::size_t>(layers.width)));
  }
  return buffer;
}

}  // namespace

std::string encode_exr(const Layers& layers, const Metadata& metadata) {
  Imf::Header header(layers.width, layers.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const Layers::Channel& channel : layers.channels) {
    header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
  }
  for (const auto& [key, value] : metadata) header.insert(key, Imf::StringAttribute(value));
  std::string bytes;
  {
    MemoryOutput stream(bytes);
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(frame_buffer(const_cast<Layers&>(layers)));  // only read from
    file.writePixels(layers.height);
  }
  return bytes;
}

DecodedExr decode_exr(std::string_view bytes, const std::string& name) {
  try {
    MemoryInput stream(bytes);
    Imf::InputFile file(stream);
    const Imf::Header& header = file.header();
    const auto& window = header.dataWindow();
    DecodedExr decoded;
    decoded.layers.width = window.max.x - window.min.x + 1;
    decoded.layers.height = window.max.y - window.min.y + 1;
    const std::size_t pixels = static_cast<std::size_t>(decoded.layers.width) *
                               static_cast<std::size_t>(decoded.layers.height);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
      decoded.layers.channels.push_back({c.name(), std::vector<float>(pixels)});
    }
    for (auto a = header.begin(); a != header.end(); ++a) {
      if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute())) {
        decoded.metadata[a.name()] = text->value();
      }
    }
    file.setFrameBuffer(frame_buffer(decoded.layers));
    file.readPixels(window.min.y, window.max.y);
    return decoded;
  } catch (const std::exception& error) {
    throw WorkError(name, std::string("damaged EXR: ") + error.what(), "is the file complete?");
  }
}

}  // namespace isolux
