#include "texture/module/srgb_input.h"

#include <kinora/math/srgb.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "image/colors.h"

namespace kinora::texture {
namespace {

class SrgbInput final : public OIIO::ImageInput {
 public:
  ~SrgbInput() override { close(); }
  const char* format_name() const override { return "kinora-srgb"; }

  bool open(const std::string& name, OIIO::ImageSpec& spec) override { return open(name, spec, OIIO::ImageSpec()); }
  bool open(const std::string& name, OIIO::ImageSpec& spec, const OIIO::ImageSpec& config) override {
    const size_t prefix = std::strlen(kSrgbPrefix);
    const std::string path = name.compare(0, prefix, kSrgbPrefix) == 0 ? name.substr(prefix) : name;
    path_ = path;
    inner_ = OIIO::ImageInput::open(path, &config);
    if (!inner_) {
      errorfmt("{}", OIIO::geterror());
      return false;
    }
    take();
    spec = m_spec;
    return true;
  }
  bool close() override {
    inner_.reset();
    return true;
  }
  int current_subimage() const override { return inner_ ? inner_->current_subimage() : 0; }
  int current_miplevel() const override { return inner_ ? inner_->current_miplevel() : 0; }
  bool seek_subimage(int subimage, int miplevel) override {
    lock_guard lock(*this);
    return seek(subimage, miplevel);
  }
  bool read_native_scanline(int subimage, int miplevel, int y, int z, void* data) override {
    lock_guard lock(*this);
    if (!seek(subimage, miplevel) || !inner_->read_scanline(y, z, OIIO::TypeFloat, scratch(m_spec.width)))
      return fail();
    return deliver(m_spec.width, data);
  }
  bool read_native_tile(int subimage, int miplevel, int x, int y, int z, void* data) override {
    lock_guard lock(*this);
    const int n = m_spec.tile_width * m_spec.tile_height;
    if (!seek(subimage, miplevel) || !inner_->read_tile(x, y, z, OIIO::TypeFloat, scratch(n))) return fail();
    return deliver(n, data);
  }

 private:
  bool seek(int subimage, int miplevel) {
    if (!inner_ || !inner_->seek_subimage(subimage, miplevel)) return false;
    take();
    return true;
  }
  // The inner file's shape. Half floats hold 8 bits of sRGB with room to spare. Hashes and constants in the header
  // describe the encoded values and would mislead the cache.
  void take() {
    m_spec = inner_->spec();
    half_ = m_spec.format == OIIO::TypeUInt8;
    m_spec.set_format(half_ ? OIIO::TypeHalf : OIIO::TypeFloat);
    for (const char* name :
         {"oiio:SHA-1", "oiio:ConstantColor", "oiio:AverageColor", "ImageDescription", "oiio:ColorSpace"})
      m_spec.erase_attribute(name);
  }
  float* scratch(int pixels) {
    scratch_.resize(size_t(pixels) * size_t(m_spec.nchannels));
    return scratch_.data();
  }
  bool deliver(int pixels, void* data) {
    // $OCIO knows better than the file's type; without it (or without a space for the file) sRGB is meant
    if (!image::Colors::ofEnvironment().toWorking(path_, half_, scratch_.data(), size_t(pixels), m_spec.nchannels,
                                                  m_spec.alpha_channel))
      decodeSrgb(scratch_.data(), size_t(pixels), m_spec.nchannels, m_spec.alpha_channel, half_);
    return OIIO::convert_pixel_values(OIIO::TypeFloat, scratch_.data(), m_spec.format, data, int(scratch_.size()));
  }
  bool fail() {
    errorfmt("{}", inner_ ? inner_->geterror() : std::string("not open"));
    return false;
  }

  std::unique_ptr<OIIO::ImageInput> inner_;
  std::string path_;
  std::vector<float> scratch_;
  bool half_ = false;
};

}  // namespace

OIIO::ImageInput* createSrgbInput() { return new SrgbInput; }

// In double precision, so that rounding hides differences between math libraries.
float decodeSrgb(float encoded) { return float(std::copysign(srgbToLinear(std::fabs(double(encoded))), encoded)); }

void decodeSrgb(float* pixels, size_t n, int channels, int alphaChannel, bool bytes) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t;
    for (int i = 0; i < 256; ++i) t[size_t(i)] = decodeSrgb(float(i) / 255.f);
    return t;
  }();
  const auto decode = [&](float v) {
    return bytes ? table[size_t(std::clamp(v * 255.f + 0.5f, 0.f, 255.f))] : decodeSrgb(v);
  };
  for (size_t i = 0; i < n; ++i)
    for (int c = 0; c < channels; ++c)
      if (c != alphaChannel)
        pixels[i * size_t(channels) + size_t(c)] = decode(pixels[i * size_t(channels) + size_t(c)]);
}

}  // namespace kinora::texture
