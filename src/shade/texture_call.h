// The options of a shader's texture call, read from its tokens and values. For the files of ShaderTextures.
#pragma once
#include <cstdint>
#include <string_view>

#include "language/program/program.h"
#include "language/vm/services.h"
#include "language/vm/strings.h"
#include "texture/texture_system.h"

namespace kinora::shade {

using language::Batch;
using language::Span;
using language::TextureCall;

inline float numberAt(const Span& v, uint32_t k, uint32_t i) {
  return v.components <= k ? 0.f : v.base == uint8_t(language::Base::Int) ? float(v.integer(k, i)) : v.number(k, i);
}
inline std::string_view textAt(const Span& v, uint32_t i) { return language::stringOf(v.integer(0, i)); }

// The options of a call; those of numbers that vary are read at each point, the others hold for a run of points.
struct TextureCallOptions {
  TextureOptions plain;
  int wrapR = 0;  // of volumes; the other two stand in `plain`
  TextureSystem::Part part;
  int32_t partText = -1;  // handle of part.name; -1: none is given
  bool hasPartNumber = false;
  Span width[3], blur[3];
  float fill = 0;
  bool hasFill = false, hasMissing = false;

  // bicubic where texels are larger than the footprint, bilinear elsewhere: what the language does unless asked
  static constexpr int kSmartCubic = 7;

  static int wrapCode(std::string_view text) {
    return text == "black" ? 0 : text == "clamp" ? 2 : text == "periodic" ? 3 : text == "mirror" ? 4 : 1;
  }
  TextureCallOptions() {
    plain.wrapS = plain.wrapT = 0;
    plain.filter = kSmartCubic;
  }
  TextureCallOptions(const TextureCall& call, uint32_t i) : TextureCallOptions() {
    for (uint32_t k = 0; k < call.options; ++k) {
      const std::string_view token = textAt(call.tokens[k], i);
      const Span& v = call.values[k];
      if (token == "width")
        width[0] = width[1] = width[2] = v;
      else if (token == "swidth")
        width[0] = v;
      else if (token == "twidth")
        width[1] = v;
      else if (token == "rwidth")
        width[2] = v;
      else if (token == "blur")
        blur[0] = blur[1] = blur[2] = v;
      else if (token == "sblur")
        blur[0] = v;
      else if (token == "tblur")
        blur[1] = v;
      else if (token == "rblur")
        blur[2] = v;
      else if (token == "wrap")
        plain.wrapS = plain.wrapT = wrapR = wrapCode(textAt(v, i));
      else if (token == "swrap")
        plain.wrapS = wrapCode(textAt(v, i));
      else if (token == "twrap")
        plain.wrapT = wrapCode(textAt(v, i));
      else if (token == "rwrap")
        wrapR = wrapCode(textAt(v, i));
      else if (token == "firstchannel")
        plain.firstChannel = int(numberAt(v, 0, i));
      else if (token == "fill")
        fill = numberAt(v, 0, i), hasFill = true;
      else if (token == "interp") {
        const std::string_view how = textAt(v, i);
        plain.filter = how == "closest" ? 0 : how == "cubic" ? 3 : how == "linear" ? 2 : kSmartCubic;
      } else if (token == "subimage") {
        hasPartNumber = v.base != uint8_t(language::Base::String);
        partText = hasPartNumber ? -1 : v.integer(0, i);
        part = {};
        if (hasPartNumber)
          part.number = int(numberAt(v, 0, i));
        else
          part.name = textAt(v, i);
      } else if (token == "missingcolor") {
        for (uint32_t j = 0; j < 3; ++j) plain.missingColor[j] = numberAt(v, v.components >= 3 ? j : 0, i);
        hasMissing = true;
      } else if (token == "missingalpha") {
        plain.missingAlpha = numberAt(v, 0, i);
      } else if (token == "colorspace") {
        plain.linearize = textAt(v, i) == "sRGB" ? 1 : 0;
      }
    }
  }
};

// Widths and blurs are each point's own anyway, and the time changes nothing.
inline bool isOwnOfPoint(std::string_view token) {
  return token.ends_with("width") || token.ends_with("blur") || token == "time";
}
// Whether other options differ from point to point.
inline bool hasVaryingOptions(const TextureCall& call) {
  for (uint32_t k = 0; k < call.options; ++k) {
    if (call.tokens[k].varies) return true;
    if (call.values[k].varies && !isOwnOfPoint(textAt(call.tokens[k], 0))) return true;
  }
  return false;
}
// Whether points i and j ask with the same ones.
inline bool sameOptions(const TextureCall& call, uint32_t i, uint32_t j) {
  const auto same = [&](const Span& v) {
    for (uint32_t k = 0; v.varies && k < v.components; ++k)
      if (v.integer(k, i) != v.integer(k, j)) return false;
    return true;
  };
  for (uint32_t k = 0; k < call.options; ++k) {
    if (!same(call.tokens[k])) return false;
    if (isOwnOfPoint(textAt(call.tokens[k], i))) continue;
    if (!same(call.values[k])) return false;
  }
  return true;
}

// A call whose arguments are the same for all points is answered once.
inline Batch pointsOf(const Batch& batch, const TextureCall& call) {
  const bool varies = call.result.varies || call.alpha.varies || call.error.varies;
  return varies ? batch : Batch{1, batch.first, nullptr};
}

}  // namespace kinora::shade
