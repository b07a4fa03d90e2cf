// Pictures that filters lay behind or over the frame: where they lie, their texels, and the lookup. What
// PxrImageDisplayFilter, PxrImagePlaneFilter and PxrWatermarkFilter are made of. The picture is brought to the raster's
// density once, by area averages, so that a lookup at a pixel is a blend of four texels. Included per target.
#ifndef KINORA_CHANNEL_PICTURE_BEFORE
#define KINORA_CHANNEL_PICTURE_BEFORE
#include <kinora/channel_filter.h>
#include <kinora/named_values.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>
#endif
#include <kinora/channel_maths.h>

#ifndef KINORA_CHANNEL_PICTURE_ONCE
#define KINORA_CHANNEL_PICTURE_ONCE
namespace kinora::channelPicture {

// fit: the default of the filter.
constexpr auto placeParams(int fit) {
  return std::array{
      param::string("filename", "").file().help("The picture; its alpha is 1 where it has none."),
      param::onOff("linearize", false).help("1: the picture is sRGB."),
      param::integer("fit", fit)
          .range(0, 4)
          .options("0 stretch, 1 inside, 2 outside, 3 horizontal, 4 vertical")
          .help("How its size follows from the frame's: 0 that of the frame, else in its own proportions: whole, "
                "covering the frame, as wide, as high."),
      param::number("offsetX", 0.f)
          .range(-2, 2)
          .help("Moves it to the right; screen space, the shorter side is 2 long."),
      param::number("offsetY", 0.f).range(-2, 2).help("Moves it up; screen space."),
      param::number("scaleX", 1.f).range(0.1f, 4).help("Widens it about its middle."),
      param::number("scaleY", 1.f).range(0.1f, 4).help("Heightens it about its middle."),
      param::number("rotate", 0.f).range(-180, 180).help("Degrees, clockwise, about its middle."),
  };
}
inline constexpr std::array kPlateParams = {
    param::color("colorGain", 1.f).range(0, 4).help("Factor on its colour."),
    param::color("colorOffset", 0.f).range(-1, 1).help("Added to its colour."),
    param::string("holdoutShadowAov", "")
        .help("Channel of the shadow on held-out objects, 1 in shadow: it darkens the picture. \"\": none."),
    param::number("filmMinX", 0.f)
        .range(-4, 4)
        .help("Left edge of the film window, screen space. The picture lies in that window as it else does in the "
              "frame, of which the window may be a part, or which may be a part of it: for plates of frames that "
              "were rendered larger or smaller than they were shot. All four 0: the frame."),
    param::number("filmMaxX", 0.f).range(-4, 4).help("Its right edge."),
    param::number("filmMinY", 0.f).range(-4, 4).help("Its lower edge."),
    param::number("filmMaxY", 0.f).range(-4, 4).help("Its upper edge."),
};

class Picture {
 public:
  std::vector<float> plane[4];    // red, green, blue (alpha in them as the file has it), alpha; row by row
  int32_t width = 0, height = 0;  // 0: there is none
  // Texel (u, v) of a raster place, counted from the middle of the first one: u = toU[0] x + toU[1] y + toU[2].
  float toU[3] = {0, 0, 0}, toV[3] = {0, 0, 0};

  // film: left, right, lower and upper edge, see kPlateParams; null: the frame.
  explicit Picture(const NamedValues& v, const double* film = nullptr) {
    const auto* frame = static_cast<const ChannelFilterInfo*>(v.info().extra);
    if (!frame || !frame->resolution[0] || !frame->resolution[1]) throw "the picture has no pixels";
    const std::string file = v.string("filename");
    const Host* host = v.info().host;
    if (file.empty()) v.warn("FILTER-PICTURE", "'filename' names no picture", "the filter does nothing");
    if (file.empty() || !host || !host->image) return;
    const HostImage* image = host->image(host->self, file.c_str(), v.integer("linearize") ? 1 : 0);
    if (!image || !image->pixels) return;  // the host has said so
    if (!image->width || !image->height || !image->channels || image->width > 1u << 17 || image->height > 1u << 17) {
      v.warn("FILTER-PICTURE", "the picture '" + file + "' is empty or too large", "the filter does nothing");
      return;
    }
    place(v, *frame, double(image->width) / image->height, film);
    double perPixel[2] = {0, 0};  // texels along u and v
    perPixel[0] = std::hypot(unit_[0][0], unit_[0][1]) * image->width;
    perPixel[1] = std::hypot(unit_[1][0], unit_[1][1]) * image->height;
    if (!std::isfinite(perPixel[0]) || !std::isfinite(perPixel[1])) throw "the picture's place is not finite";
    const auto size = [](uint32_t texels, double perPixel_) {
      return std::clamp(int32_t(std::ceil(texels / std::max(1.0, perPixel_) - 1e-6)), 1, int32_t(texels));
    };
    width = size(image->width, perPixel[0]);
    height = size(image->height, perPixel[1]);
    fill(*image);
    const int32_t texels[2] = {width, height};
    for (int a = 0; a < 2; ++a)
      for (int k = 0; k < 3; ++k) (a ? toV : toU)[k] = float(unit_[a][k] * texels[a] - (k == 2 ? 0.5 : 0));
  }

 private:
  // The unit square of the picture, v down, of a raster place.
  void place(const NamedValues& v, const ChannelFilterInfo& frame, double aspect, const double* film) {
    const double w = frame.resolution[0], h = frame.resolution[1], frameAspect = w * frame.pixelAspect / h;
    // halves of the frame and of the picture, in screen space
    const double fx = frameAspect > 1 ? frameAspect : 1, fy = frameAspect > 1 ? 1 : 1 / frameAspect;
    const double hx = film ? (film[1] - film[0]) / 2 : fx, hy = film ? (film[3] - film[2]) / 2 : fy;
    double px = hx, py = hy;
    const int fit = v.integer("fit");
    if (fit >= 1 && fit <= 4) {
      const double wide = hx / aspect, high = hy;
      py = fit == 1 ? std::min(wide, high) : fit == 2 ? std::max(wide, high) : fit == 3 ? wide : high;
      px = py * aspect;
    }
    const auto safe = [](double x) { return std::fabs(x) > 1e-6 ? x : std::copysign(1e-6, x); };
    px *= safe(v.number("scaleX"));
    py *= safe(v.number("scaleY"));
    const double turn = v.number("rotate") * 3.14159265358979323846 / 180, c = std::cos(turn), s = std::sin(turn);
    // screen place minus offset, turned back
    const double sx[3] = {2 * fx / w, 0, -fx - v.number("offsetX") - (film ? film[0] + hx : 0)},
                 sy[3] = {0, -2 * fy / h, fy - v.number("offsetY") - (film ? film[2] + hy : 0)};
    for (int k = 0; k < 3; ++k) {
      unit_[0][k] = (c * sx[k] - s * sy[k]) / (2 * px) + (k == 2 ? 0.5 : 0);
      unit_[1][k] = -(s * sx[k] + c * sy[k]) / (2 * py) + (k == 2 ? 0.5 : 0);
    }
  }
  // Area averages of the file's texels.
  void fill(const HostImage& image) {
    const uint32_t n = image.channels, alpha = n == 2 ? 1 : n >= 4 ? 3 : n;
    const size_t columns = size_t(width);
    std::vector<double> rows(columns * 4), row(columns * 4);
    for (auto& p : plane) p.resize(columns * size_t(height));
    const double stepX = double(image.width) / width, stepY = double(image.height) / height;
    for (int32_t y = 0; y < height; ++y) {
      std::fill(rows.begin(), rows.end(), 0.0);
      const double y0 = y * stepY, y1 = y0 + stepY;
      for (uint32_t j = uint32_t(y0); j < image.height && j < y1; ++j) {
        const double share = std::min(double(j + 1), y1) - std::max(double(j), y0);
        if (!(share > 0)) continue;
        averageRow(image.pixels + size_t(j) * image.width * n, image.width, n, alpha, stepX, row);
        for (size_t i = 0; i < row.size(); ++i) rows[i] += share / stepY * row[i];
      }
      for (size_t x = 0; x < columns; ++x)
        for (size_t c = 0; c < 4; ++c) plane[c][size_t(y) * columns + x] = float(rows[4 * x + c]);
    }
  }
  static void averageRow(const float* texels, uint32_t count, uint32_t n, uint32_t alpha, double step,
                         std::vector<double>& out) {
    const auto good = [](double x) { return std::isfinite(x) ? std::clamp(x, -1e9, 1e9) : 0.0; };
    for (size_t x = 0; 4 * x < out.size(); ++x) {
      const double x0 = double(x) * step, x1 = x0 + step;
      double sum[4] = {0, 0, 0, 0};
      for (uint32_t i = uint32_t(x0); i < count && i < x1; ++i) {
        const double share = std::min(double(i + 1), x1) - std::max(double(i), x0);
        if (!(share > 0)) continue;
        const float* t = texels + size_t(i) * n;
        for (uint32_t c = 0; c < 3; ++c) sum[c] += share * good(t[n < 3 ? 0 : c]);
        sum[3] += share * (alpha < n ? good(t[alpha]) : 1);
      }
      for (size_t c = 0; c < 4; ++c) out[4 * x + c] = sum[c] / step;
    }
  }

  double unit_[2][3] = {{0, 0, 0}, {0, 0, 0}};
};

// The film window of kPlateParams.
class Film {
 public:
  explicit Film(const NamedValues& v) {
    const char* const kNames[4] = {"filmMinX", "filmMaxX", "filmMinY", "filmMaxY"};
    bool isGiven = false;
    for (int i = 0; i < 4; ++i) {
      edge_[i] = v.number(kNames[i]);
      isGiven = isGiven || edge_[i] != 0;
    }
    isThere_ = edge_[1] - edge_[0] > 1e-6 && edge_[3] - edge_[2] > 1e-6;
    if (isGiven && !isThere_)
      v.warn("FILTER-FILM", "the film window from filmMinX, filmMinY to filmMaxX, filmMaxY is empty",
             "the picture lies in the frame");
  }
  const double* window() const { return isThere_ ? edge_ : nullptr; }

 private:
  double edge_[4];
  bool isThere_ = false;
};

// A picture behind the frame.
struct Plate {
  Picture picture;
  std::string shadow;
  float gain[3], offset[3];
  bool usesAlpha = false;
  Plate(const NamedValues& v, bool usesAlpha_)
      : picture(v, Film(v).window()), shadow(v.string("holdoutShadowAov")), usesAlpha(usesAlpha_) {
    for (int c = 0; c < 3; ++c) {
      gain[c] = float(v.number("colorGain", c));
      offset[c] = float(v.number("colorOffset", c));
    }
  }
  const char* channel(uint32_t i) const {
    return i == 0 ? "Ci" : i == 1 ? "a" : i == 2 && !shadow.empty() ? shadow.c_str() : nullptr;
  }
};

}  // namespace kinora::channelPicture
#endif

#if defined(KINORA_CHANNEL_PICTURE_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CHANNEL_PICTURE_H_TARGET
#undef KINORA_CHANNEL_PICTURE_H_TARGET
#else
#define KINORA_CHANNEL_PICTURE_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

// Colour and alpha at the pixels of a span; 0 beyond the picture.
template <int W>
KN_INLINE void lookUpPicture(const channelPicture::Picture& p, const ChannelSpan<W>& s, Rgb<W>& color,
                             Float<W>& alpha) {
  using F = Float<W>;
  const F x = s.x(), y = s.y();
  const F u = fma(x, F(p.toU[0]), fma(y, F(p.toU[1]), F(p.toU[2]))),
          v = fma(x, F(p.toV[0]), fma(y, F(p.toV[1]), F(p.toV[2])));
  const F lastU(float(p.width - 1)), lastV(float(p.height - 1)), half(0.5f);
  const Mask<W> inside = (u >= -half) & (u <= lastU + half) & (v >= -half) & (v <= lastV + half);
  const F cu = clamp(u, F(0.f), lastU), cv = clamp(v, F(0.f), lastV), fu = floor(cu), fv = floor(cv);
  const Int<W> u0 = toInt(fu), v0 = toInt(fv) * Int<W>(p.width), u1 = toInt(min(fu + F(1.f), lastU)),
               v1 = toInt(min(fv + F(1.f), lastV)) * Int<W>(p.width);
  const F au = cu - fu, av = cv - fv;
  const auto one = [&](int c) {
    const float* t = p.plane[c].data();
    const F above = lerp(gather(t, v0 + u0), gather(t, v0 + u1), au),
            below = lerp(gather(t, v1 + u0), gather(t, v1 + u1), au);
    return zeroUnless(inside, lerp(above, below, av));
  };
  color = Rgb<W>(one(0), one(1), one(2));
  alpha = one(3);
}

struct PlateFilter {
  using Data = channelPicture::Plate;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!k.picture.width || !s.has(0) || !s.has(1)) return;
    Rgb<W> plate;
    F covers;
    lookUpPicture(k.picture, s, plate, covers);
    const Mask<W> there = covers != F(0.f);
    const F room = max(F(1.f) - s.number(1), F(0.f));
    plate = Rgb<W>(fma(plate.x, F(k.gain[0]), F(k.offset[0])), fma(plate.y, F(k.gain[1]), F(k.offset[1])),
                   fma(plate.z, F(k.gain[2]), F(k.offset[2])));
    plate = zeroUnless(there, plate);
    if (!k.shadow.empty() && s.has(2)) {
      const Rgb<W> shadow = s.rgb(2);
      const auto lit = [](F x) { return clamp(F(1.f) - x, F(0.f), F(1.f)); };
      plate = Rgb<W>(plate.x * lit(shadow.x), plate.y * lit(shadow.y), plate.z * lit(shadow.z));
    }
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(fma(room, plate.x, c.x), fma(room, plate.y, c.y), fma(room, plate.z, c.z)));
    if (k.usesAlpha) s.set(1, fma(room, covers, s.number(1)));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
