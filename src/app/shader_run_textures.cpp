// Textures of `kinora shader run`: the renderer's texture system over files named from the working directory.
#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>

#include "app/shader_run.h"
#include "image/read_write.h"
#include "language/vm/strings.h"
#include "texture/texture_system.h"

namespace kinora::app {

using language::Base;
using language::Batch;
using language::Span;
using language::Type;
using language::Values;

struct ShadeTextures::Impl {
  Diagnostics diagnostics;
  TextureSystem system{diagnostics};
  std::map<int32_t, int> handles;
  std::map<int32_t, std::optional<image::Image>> headers;

  int handleOf(int32_t name) {
    const auto [at, isNew] = handles.try_emplace(name, TextureSystem::kNoTexture);
    const std::string& file = language::stringOf(name);
    if (isNew && !file.empty()) at->second = system.handle(file, {{}, "a texture call"});
    return at->second;
  }
  const image::Image* headerOf(int32_t name) {
    const auto [at, isNew] = headers.try_emplace(name);
    if (isNew) {
      image::Image header;
      if (image::readHeader(language::stringOf(name), header).ok()) at->second = std::move(header);
    }
    return at->second ? &*at->second : nullptr;
  }
};

ShadeTextures::ShadeTextures() : impl_(std::make_unique<Impl>()) {}
ShadeTextures::~ShadeTextures() = default;

namespace {

int wrapNamed(std::string_view text) {
  return text == "clamp" ? 2 : text == "periodic" ? 3 : text == "mirror" ? 1 : 0;
}

float valueAt(const Span& v, uint32_t k, uint32_t i) {
  return v.components <= k ? 0.f : v.base == uint8_t(Base::Int) ? float(v.integer(k, i)) : v.number(k, i);
}

}  // namespace

void ShadeTextures::texture(const Batch& batch, const language::TextureCall& call) {
  const uint32_t n = call.result.varies ? batch.points : 1, padded = (n + 15) / 16 * 16;
  TextureOptions options;
  options.wrapS = options.wrapT = 0;
  options.filter = 2;
  options.linearize = 0;  // numbers as they are stored, as other programs of this language see them
  Span width[2], blur[2];
  for (uint32_t k = 0; k < call.options; ++k) {
    const std::string_view token = language::stringOf(call.tokens[k].integer(0, 0));
    const Span& v = call.values[k];
    const auto text = [&] { return std::string_view(language::stringOf(v.integer(0, 0))); };
    if (token == "width") width[0] = width[1] = v;
    if (token == "swidth") width[0] = v;
    if (token == "twidth") width[1] = v;
    if (token == "blur") blur[0] = blur[1] = v;
    if (token == "sblur") blur[0] = v;
    if (token == "tblur") blur[1] = v;
    if (token == "wrap" || token == "swrap") options.wrapS = wrapNamed(text());
    if (token == "wrap" || token == "twrap") options.wrapT = wrapNamed(text());
    if (token == "firstchannel") options.firstChannel = int(valueAt(v, 0, 0));
    if (token == "interp" && text() == "closest") options.filter = 0;
    if (token == "missingcolor" && v.components >= 3)
      for (uint32_t j = 0; j < 3; ++j) options.missingColor[j] = valueAt(v, j, 0);
    if (token == "missingalpha") options.missingAlpha = valueAt(v, 0, 0);
    if (token == "colorspace") options.linearize = text() == "sRGB" ? 1 : 0;
  }
  std::vector<float> memory(size_t(padded) * 7, 0.f);
  float* const st[3] = {memory.data(), memory.data() + padded, memory.data() + 2 * padded};
  float* const rgba[4] = {memory.data() + 3 * padded, memory.data() + 4 * padded, memory.data() + 5 * padded,
                          memory.data() + 6 * padded};
  std::vector<int32_t> handles(padded);
  for (uint32_t j = 0; j < padded; ++j) {
    const uint32_t i = std::min(j, n - 1);
    st[0][j] = call.coordinates.number(0, i);
    st[1][j] = call.coordinates.number(1, i);
    float size = 0;  // half the longer step across the picture
    for (const Span* d : {&call.dx, &call.dy}) {
      float l2 = 0;
      for (uint32_t k = 0; k < 2; ++k) {
        const float x = valueAt(*d, k, i) * (width[k].components ? valueAt(width[k], 0, i) : 1.f);
        l2 += x * x;
      }
      size = std::max(size, 0.5f * std::sqrt(l2));
    }
    st[2][j] = size + 0.5f * std::max(valueAt(blur[0], 0, i), valueAt(blur[1], 0, i));
    handles[j] = batch.isLive(i) || n == 1 ? impl_->handleOf(call.file.integer(0, i)) : TextureSystem::kNoTexture;
  }
  impl_->system.lookup(handles.data(), true, padded, st[0], st[1], st[2], options, rgba);
  for (uint32_t i = 0; i < n; ++i) {
    if (n > 1 && !batch.isLive(i)) continue;
    for (uint32_t k = 0; k < call.result.components; ++k) call.result.set(k, i, rgba[std::min(k, 3u)][i]);
    if (call.alpha.components) call.alpha.set(0, i, rgba[3][i]);
    if (call.error.components)
      call.error.set(0, i, language::internString(handles[i] < 0 ? "the texture is not there" : ""));
  }
}

void ShadeTextures::info(const Batch& batch, Span file, Span name, Span to, Span found) {
  const uint32_t n = found.varies || to.varies ? batch.points : 1;
  for (uint32_t i = 0; i < n; ++i) {
    if (n > 1 && !batch.isLive(i)) continue;
    const std::string& asked = language::stringOf(name.integer(0, i));
    const image::Image* header = impl_->headerOf(file.integer(0, i));
    Type type{Base::Int, 0, -1};
    Values values;
    bool isThere = header != nullptr;
    if (asked == "exists") {
      values.ints = {header != nullptr};
      isThere = true;
    } else if (!header) {
    } else if (asked == "resolution") {
      values.ints = {header->width(), header->height()};
      if (to.components == 3) values.ints.push_back(1);
    } else if (asked == "channels") {
      values.ints = {header->channelCount()};
    } else if (asked == "subimages" || asked == "miplevels") {
      values.ints = {1};
    } else if (asked == "datawindow") {
      values.ints = {header->data.x0, header->data.y0, header->data.x1 - 1, header->data.y1 - 1};
    } else if (asked == "displaywindow") {
      values.ints = {header->display.x0, header->display.y0, header->display.x1 - 1, header->display.y1 - 1};
    } else if (asked == "textureformat") {
      type.base = Base::String;
      values.strings = {"Plain Texture"};
    } else if (const auto at = header->metadata.find(asked); at != header->metadata.end()) {
      type.base = Base::Float;
      if (const int* number = std::get_if<int>(&at->second)) {
        type.base = Base::Int;
        values.ints = {*number};
      } else if (const float* f = std::get_if<float>(&at->second)) {
        values.floats = {*f};
      } else if (const std::string* s = std::get_if<std::string>(&at->second)) {
        type.base = Base::String;
        values.strings = {*s};
      } else {
        const auto& m = std::get<image::Matrix44>(at->second);
        values.floats.assign(m.begin(), m.end());
      }
    } else {
      isThere = false;
    }
    found.set(0, i, int32_t(isThere && giveAttribute(type, values, to, i)));
  }
}

}  // namespace kinora::app
