#include "film/display_values.h"

#include <algorithm>
#include <cmath>

namespace kinora::film {
namespace {

// IEC 61966-2-1
float encode(float x) { return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f; }
float decode(float y) { return y <= 0.04045f ? y / 12.92f : std::pow((y + 0.055f) / 1.055f, 2.4f); }

// -1..1 by pixel and component: the same in every snapshot and after every merge.
float noise(int x, int y, int component) {
  uint32_t h = uint32_t(x) * 0x9E3779B1u ^ uint32_t(y) * 0x85EBCA77u ^ uint32_t(component) * 0xC2B2AE3Du;
  h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
  h = (h ^ (h >> 12)) * 0x297A2D39u;
  h ^= h >> 15;
  return float(h >> 8) * (2.0f / 16777216.0f) - 1.0f;
}

}  // namespace

DisplayValues displayValues(const std::array<float, 2>& exposure, const scene::ParameterList& display,
                            const scene::ParameterList* channel, const std::string& name, const SourcePos& pos,
                            Diagnostics& diagnostics) {
  DisplayValues v;
  v.gain = exposure[0];
  v.gamma = exposure[1];
  const auto given = [&](const char* parameter) -> const scene::Parameter* {
    const scene::Parameter* p = channel ? channel->find(parameter) : nullptr;
    return p ? p : display.find(parameter);
  };
  const auto numbers = [&](const scene::Parameter& p) {
    return p.floats.empty() ? std::vector<float>(p.ints.begin(), p.ints.end()) : p.floats;
  };
  const auto refuse = [&](const scene::Parameter& p, const char* wanted) {
    diagnostics.warning("DISPLAY-PARAMETER", p.pos.file ? p.pos : pos,
                        "parameter \"" + p.name + "\" of \"" + name + "\" is not " + wanted, "it is ignored");
  };
  const auto finite = [](const std::vector<float>& list) {
    return std::all_of(list.begin(), list.end(), [](float x) { return std::isfinite(x); });
  };
  if (const scene::Parameter* p = given("exposure")) {
    const std::vector<float> n = numbers(*p);
    if (n.size() == 2 && finite(n) && n[0] >= 0 && n[1] > 0) {
      v.gain = n[0];
      v.gamma = n[1];
    } else {
      refuse(*p, "a gain of at least 0 and a gamma above 0");
    }
  }
  if (const scene::Parameter* p = given("quantize"); p && !(p->floats.size() == 1 || p->ints.size() == 1)) {
    // one number is the png driver's own switch
    const std::vector<float> n = numbers(*p);
    if (n.size() != 4 || !finite(n) || n[1] < 0 || (n[1] > 0 && !(n[2] < n[3]))) {
      refuse(*p, "four numbers: zero, one, and a least below a most");
    } else if (n[1] > 0) {
      v.zero = n[0];
      v.one = n[1];
      v.least = n[2];
      v.most = n[3];
    }
  }
  if (const scene::Parameter* p = given("dither")) {
    const std::vector<float> n = numbers(*p);
    if (n.size() == 1 && finite(n) && n[0] >= 0)
      v.dither = n[0];
    else
      refuse(*p, "one number of at least 0");
  }
  return v;
}

float displayed(float value, const DisplayValues& v, bool isColor, float largestCode, bool isEncoded, int x, int y,
                int component) {
  const bool toIntegers = largestCode > 0;
  if (isColor && v.isExposed()) {
    value *= v.gain;
    if (v.gamma != 1) {
      value = std::copysign(std::pow(std::fabs(value), 1 / v.gamma), value);
      // the gamma is the encoding of what is stored: the driver's own comes off
      if (toIntegers && isEncoded) value = decode(value);
    }
  }
  const float shift = v.dither > 0 ? v.dither * noise(x, y, component) : 0;
  if (!toIntegers) {
    if (!v.isQuantised()) return value;
    const float q = std::floor(v.zero + value * (v.one - v.zero) + shift + 0.5f);
    return std::clamp(q, v.least, v.most) / v.one;
  }
  const DisplayValues codes = v.isQuantised() ? v : DisplayValues{1, 1, 0, largestCode, 0, largestCode, 0};
  // what the driver does by itself
  const bool isPlain = codes.zero == 0 && codes.one == largestCode && codes.least <= 0 && codes.most >= largestCode;
  if (isPlain && shift == 0) return value;
  const float level = isEncoded ? encode(std::max(0.0f, value)) : value;
  const float code =
      std::clamp(std::floor(codes.zero + level * (codes.one - codes.zero) + shift + 0.5f), codes.least, codes.most);
  return isEncoded ? decode(code / largestCode) : code / largestCode;
}

}  // namespace kinora::film
