// The picture that PxrCookieLightFilter and PxrGoboLightFilter project: its parameters and the texels, corrected once.
// Plain; picture_kernel.h looks it up.
#pragma once
#include "plugins/lightfilter/parts/plane.h"

namespace kinora::filterParts {

inline constexpr std::array kPictureParams = {
    param::string("map", "ratGrid.tex").file().help("Image that is projected, upright where +y is up."),
    param::color("fillColor", 1.f).help("Factor outside of the image and behind its transparent parts."),
    param::onOff("linearize", false).help("1: the image is sRGB."),
    param::onOff("premultipliedAlpha", true).help("1: the image's colours hold its alpha."),
    param::integer("tileMode", 0)
        .range(0, 2)
        .options("0 fillColor outside, 1 edges go on, 2 repeated")
        .help("What lies outside of the image."),
    param::number("offsetU", 0.f).range(-1, 1).help("Moves the image in x, in its widths."),
    param::number("offsetV", 0.f).range(-1, 1).help("Moves the image in y, in its heights."),
    param::number("scaleU", 1.f).range(0.1f, 4).help("Widens the image about its middle."),
    param::number("scaleV", 1.f).range(0.1f, 4).help("Heightens the image about its middle."),
    param::flag("refreshMap", false).help("No effect: images are read anew when they change."),
};

struct Picture {
  LightMap map;
  float fill[3] = {1, 1, 1};
  float mostOfAll = 1;
  int tileMode = 0;
  float perWidth = 1, perHeight = 1, perScaleU = 1, perScaleV = 1, offsetU = 0, offsetV = 0;
  float vScale = 1, vOffset = 0;  // repeated images have a row more on either side

  struct Grade {
    bool usesAlpha = true, inverted = false;
    double whitepoint = 1, midpoint = 0.18, contrast = 1, intensity = 1, tint[3] = {1, 1, 1};
  };

  // An image that is missing or unusable leaves the light unfiltered.
  void set(const NamedValues& v, const Grade& g) {
    tileMode = std::clamp(v.integer("tileMode"), 0, 2);
    perWidth = float(1 / std::max(v.number("width"), 1e-6));
    perHeight = float(1 / std::max(v.number("height"), 1e-6));
    const auto safe = [](double x) { return std::fabs(x) > 1e-6 ? x : std::copysign(1e-6, x); };
    perScaleU = float(1 / safe(v.number("scaleU")));
    perScaleV = float(1 / safe(v.number("scaleV")));
    offsetU = float(v.number("offsetU"));
    offsetV = float(v.number("offsetV"));
    for (int c = 0; c < 3; ++c) fill[c] = float(std::clamp(v.number("fillColor", c), 0.0, 1e18));
    const std::string file = v.string("map");
    const Host* host = v.info().host;
    if (!host || !host->image) return;
    const HostImage* image =
        file.empty() ? nullptr : host->image(host->self, file.c_str(), v.integer("linearize") ? 1 : 0);
    if (file.empty()) v.warn("LIGHT-FILTER-MAP", "'map' names no image", "the light is unfiltered");
    if (!image || !image->pixels) return;  // the host has said so
    const uint64_t border = tileMode == 2 ? 1 : 0, rows = image->height + 2 * border;
    if (!image->width || !image->height || !image->channels || image->channels > 64 || image->width > 1u << 20 ||
        image->height > 1u << 20 || rows * image->width * 3 > 0x7fffffffu) {
      v.warn("LIGHT-FILTER-MAP", "the image '" + file + "' is empty or too large", "the light is unfiltered");
      return;
    }
    map.own.resize(rows * image->width * 3);
    for (uint64_t y = 0; y < rows; ++y)
      for (uint64_t x = 0; x < image->width; ++x) {
        const uint64_t from = (y + image->height - border) % image->height;
        put(image->pixels + (from * image->width + x) * image->channels, image->channels, g,
            v.integer("premultipliedAlpha") != 0, map.own.data() + (y * image->width + x) * 3);
      }
    map.texels = map.own.data();
    map.width = int32_t(image->width);
    map.height = int32_t(rows);
    map.stride = 3;
    map.green = 1;
    map.blue = 2;
    vScale = float(double(image->height) / double(rows));
    vOffset = float(double(border) / double(rows));
    mostOfAll = std::max({fill[0], fill[1], fill[2]});
    for (float x : map.own) mostOfAll = std::max(mostOfAll, x);
  }

 private:
  void put(const float* texel, uint32_t channels, const Grade& g, bool premultiplied, float* out) const {
    const auto good = [](double x) { return std::isfinite(x) ? std::clamp(x, 0.0, 1e9) : 0.0; };
    const bool hasAlpha = g.usesAlpha && (channels == 2 || channels >= 4);
    const double alpha = hasAlpha ? std::min(good(texel[channels == 2 ? 1 : 3]), 1.0) : 1;
    for (int c = 0; c < 3; ++c) {
      double x = good(texel[channels < 3 ? 0 : c]);
      if (hasAlpha && premultiplied) x = alpha > 0 ? x / alpha : 0;
      x /= g.whitepoint;
      if (g.contrast != 1) x = g.midpoint * std::pow(x / g.midpoint, g.contrast);
      if (g.inverted) x = std::max(0.0, 1 - x);
      x *= g.tint[c] * g.intensity;
      out[c] = float(good(fill[c] + (x - fill[c]) * alpha));
    }
  }
};

}  // namespace kinora::filterParts
