#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "isolux/base/error.h"
#include "isolux/image/exr.h"
#include "isolux/image/png.h"

namespace isolux {
namespace {

const Metadata kTexts{{"Software", "isolux 1"}, {"isolux.scene", "{\"a\": \"\u00e4 \u03b8\"}"}};

Picture gradient() {
  Picture picture{5, 3, {}};
  for (std::uint8_t n = 0; n < 45; ++n) picture.rgb.push_back(static_cast<std::uint8_t>(n * 5));
  return picture;
}

Layers two_channels() {
  Layers layers{3, 2, {{"R", {0, 1, 2, 3, 4, 5}}, {"depth.Z", {1, 2, INFINITY, -0.5F, 1e-30F, 7}}}};
  return layers;
}

TEST(Png, pixels_and_texts_come_back) {
  const DecodedPng decoded = decode_png(encode_png(gradient(), kTexts, true), "a.png");
  EXPECT_EQ(decoded.picture.width, 5);
  EXPECT_EQ(decoded.picture.height, 3);
  EXPECT_EQ(decoded.picture.rgb, gradient().rgb);
  EXPECT_EQ(decoded.metadata, kTexts);
}

TEST(Png, every_cut_is_an_error_and_not_a_crash) {
  const std::string bytes = encode_png(gradient(), kTexts, false);
  for (std::size_t length = 0; length + 12 < bytes.size(); ++length) {  // IEND may be missing
    EXPECT_THROW(decode_png(std::string_view(bytes).substr(0, length), "cut.png"), WorkError)
        << length;
  }
}

TEST(Exr, channels_and_texts_come_back) {
  const DecodedExr decoded = decode_exr(encode_exr(two_channels(), kTexts), "a.exr");
  EXPECT_EQ(decoded.layers.width, 3);
  EXPECT_EQ(decoded.layers.height, 2);
  for (const Layers::Channel& channel : two_channels().channels) {
    ASSERT_NE(decoded.layers.find(channel.name), nullptr);
    EXPECT_EQ(decoded.layers.find(channel.name)->values, channel.values);
  }
  EXPECT_EQ(decoded.metadata, kTexts);
}

TEST(Exr, every_cut_is_an_error_and_not_a_crash) {
  const std::string bytes = encode_exr(two_channels(), kTexts);
  for (std::size_t length = 0; length < bytes.size(); length += 3) {
    EXPECT_THROW(decode_exr(std::string_view(bytes).substr(0, length), "cut.exr"), WorkError)
        << length;
  }
}

TEST(PictureFiles, the_same_picture_has_the_same_bytes) {
  EXPECT_EQ(encode_png(gradient(), kTexts, true), encode_png(gradient(), kTexts, true));
  EXPECT_EQ(encode_exr(two_channels(), kTexts), encode_exr(two_channels(), kTexts));
}

}  // namespace
}  // namespace isolux
