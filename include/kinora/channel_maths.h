// What the sample filters and the display filters of one name have in common: grade, filmic tone curve, white point,
// copy, background, shadow. Each is a struct with its parameters and data and one with its function, to be given to
// SampleFilterRunner or DisplayFilterRunner. Included per target.
#ifndef KINORA_CHANNEL_MATHS_BEFORE
#define KINORA_CHANNEL_MATHS_BEFORE
#include <kinora/channel_filter.h>
#include <kinora/grade_params.h>
#include <kinora/light_setup.h>
#include <kinora/named_values.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#endif
#include <kinora/channel_filter_author.h>
#include <kinora/math/elementary.h>

#ifndef KINORA_CHANNEL_MATHS_ONCE
#define KINORA_CHANNEL_MATHS_ONCE
namespace kinora::channelMaths {
// What changes a colour by its alpha works on these channels.
struct ColorAndAlpha {
  std::string aov, alpha;
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : i == 1 ? alpha.c_str() : nullptr; }
};

inline constexpr Param kAov = param::string("aov", "Ci").help("Channel that is changed.");

inline constexpr auto kGradeParams =
    joinParams(std::array{param::string("aov", "Ci").help("Channel that is graded.")}, gradeParams::kGrade);
struct Grade {
  std::string aov;
  float black[3], scale[3], add[3], power[3], mask[3];
  bool clampBlack, clampWhite;
  explicit Grade(const CreateInfo& info) {
    const NamedValues v(info, kGradeParams.data(), kGradeParams.size());
    aov = v.string("aov");
    for (int c = 0; c < 3; ++c) {
      const double from = v.number("blackPoint", c), range = v.number("whitePoint", c) - from;
      if (std::fabs(range) < 1e-6) throw "blackPoint and whitePoint are the same";
      const double gamma = v.number("gamma", c);
      black[c] = float(from);
      scale[c] = float(v.number("multiply", c) * v.number("gain", c) / range);
      add[c] = float(v.number("lift", c) + v.number("offset", c));
      power[c] = gamma > 1e-3 ? float(1 / gamma) : 1.f;
      mask[c] = float(v.number("mask", c));
    }
    clampBlack = v.integer("clampBlack") != 0;
    clampWhite = v.integer("clampWhite") != 0;
  }
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : nullptr; }
};

// J. Hable's curve ("Filmic Tonemapping Operators", 2010; "Uncharted 2: HDR Lighting", GDC 2010).
inline constexpr std::array kFilmicParams = {
    kAov,
    param::number("exposureAdjust", 1.f).range(0.1f, 8).help("Factor on the colour before the curve."),
    param::number("A", 0.22f).range(0.01f, 1).help("Strength of the shoulder."),
    param::number("B", 0.3f).range(0.01f, 1).help("Strength of the straight part."),
    param::number("C", 0.1f).range(0.01f, 1).help("Angle of the straight part."),
    param::number("D", 0.2f).range(0.01f, 1).help("Strength of the toe."),
    param::number("E", 0.01f).range(0, 0.1f).help("Numerator of the toe."),
    param::number("F", 0.3f).range(0.1f, 1).help("Denominator of the toe."),
    param::number("linearWhitePoint", 11.2f).range(1, 20).help("Colour that becomes 1."),
};
struct Filmic {
  std::string aov;
  float exposure, a, b, cb, de, df, ef, perWhite;
  explicit Filmic(const CreateInfo& info) {
    const NamedValues v(info, kFilmicParams.data(), kFilmicParams.size());
    aov = v.string("aov");
    const double A = v.number("A"), B = v.number("B"), C = v.number("C"), D = v.number("D"), E = v.number("E"),
                 F = v.number("F"), w = v.number("linearWhitePoint");
    if (!(A >= 0 && B >= 0 && D * F > 0 && w > 0))
      throw "the curve is none: A and B below 0, or D, F or the white point not above it";
    const double white = (w * (A * w + C * B) + D * E) / (w * (A * w + B) + D * F) - E / F;
    if (!(white > 1e-6)) throw "the curve does not rise to its white point";
    exposure = float(v.number("exposureAdjust"));
    a = float(A);
    b = float(B);
    cb = float(C * B);
    de = float(D * E);
    df = float(D * F);
    ef = float(E / F);
    perWhite = float(1 / white);
  }
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : nullptr; }
};

inline constexpr std::array kWhitePointParams = {
    kAov,
    param::number("temperature", 6500.f)
        .range(1000, 10000)
        .help("Kelvin of the light that becomes neutral; 6500 changes nothing."),
    param::onOff("useManualWhitePoint", false).help("1: by manualWhitePoint instead."),
    param::color("manualWhitePoint", 1.f).range(0.1f, 2).help("Colour that becomes neutral, with its luminance."),
};
struct WhitePoint {
  std::string aov;
  float scale[3];
  explicit WhitePoint(const CreateInfo& info) {
    const NamedValues v(info, kWhitePointParams.data(), kWhitePointParams.size());
    aov = v.string("aov");
    double white[3];
    if (v.integer("useManualWhitePoint")) {
      for (int c = 0; c < 3; ++c) white[c] = v.number("manualWhitePoint", c);
    } else {
      const auto of = blackbody(v.number("temperature")), neutral = blackbody(6500);
      for (size_t c = 0; c < 3; ++c) white[c] = std::fmax(of[c], 1e-3) / neutral[c];
    }
    const double luminance = 0.2126 * white[0] + 0.7152 * white[1] + 0.0722 * white[2];
    for (int c = 0; c < 3; ++c) {
      if (!(white[c] > 1e-6)) throw "the white point has a channel that is not above 0";
      scale[c] = float(luminance / white[c]);
    }
  }
  const char* channel(uint32_t i) const { return i == 0 ? aov.c_str() : nullptr; }
};

inline constexpr std::array kCopyParams = {
    param::string("readAov", "").help("Channel that is copied; a single float becomes grey."),
    param::string("writeAov", "Ci").help("Channel that is overwritten."),
};
struct Copy {
  std::string from, to;
  explicit Copy(const CreateInfo& info) {
    const NamedValues v(info, kCopyParams.data(), kCopyParams.size());
    from = v.string("readAov");
    to = v.string("writeAov");
  }
  const char* channel(uint32_t i) const { return i == 0 ? from.c_str() : i == 1 ? to.c_str() : nullptr; }
};

// How much of a light is missing: 1 - occluded / unoccluded, by channel.
inline constexpr std::array kShadowParams = {
    param::string("occludedAov", "").help("Channel of the light with shadows."),
    param::string("unoccludedAov", "").help("Channel of the light without them."),
    param::string("shadowAov", "").help("Channel that gets the shadow: 0 lit, 1 in shadow."),
};
inline constexpr std::array kThreshold = {
    param::number("shadowThreshold", 0.01f).help("Where there is less light than this, there is no shadow."),
};
struct Shadow {
  std::string occluded, unoccluded, shadow;
  float threshold;
  Shadow(const NamedValues& v, double least)
      : occluded(v.string("occludedAov")),
        unoccluded(v.string("unoccludedAov")),
        shadow(v.string("shadowAov")),
        threshold(float(std::fmax(least, 1e-6))) {}
  const char* channel(uint32_t i) const {
    return i == 0 ? occluded.c_str() : i == 1 ? unoccluded.c_str() : i == 2 ? shadow.c_str() : nullptr;
  }
};

struct Background : ColorAndAlpha {
  float color[3];
  float opacity = 0;  // of the background: its part of alpha
  Background(const NamedValues& v, std::string aov_, std::string alpha_, double opacity_ = 0)
      : ColorAndAlpha{std::move(aov_), std::move(alpha_)}, opacity(float(opacity_)) {
    for (int c = 0; c < 3; ++c) color[c] = float(v.number("backgroundColor", c));
  }
};

template <class Data>
const char* channelOf(const void* data, uint32_t i) {
  return static_cast<const Data*>(data)->channel(i);
}
}  // namespace kinora::channelMaths
#endif

#if defined(KINORA_CHANNEL_MATHS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_CHANNEL_MATHS_H_TARGET
#undef KINORA_CHANNEL_MATHS_H_TARGET
#else
#define KINORA_CHANNEL_MATHS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {

struct GradeFilter {
  using Data = channelMaths::Grade;
  template <int W>
  static KN_INLINE Float<W> one(const Data& k, int c, Float<W> x) {
    using F = Float<W>;
    F y = fma(x - F(k.black[c]), F(k.scale[c]), F(k.add[c]));
    if (k.power[c] != 1.f) y = select(y > F(0.f), pow(max(y, F(1e-30f)), F(k.power[c])), y);
    if (k.clampBlack) y = max(y, F(0.f));
    if (k.clampWhite) y = min(y, F(1.f));
    return k.mask[c] == 1.f ? y : fma(F(k.mask[c]), y - x, x);
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(one(k, 0, c.x), one(k, 1, c.y), one(k, 2, c.z)));
  }
};

struct FilmicFilter {
  using Data = channelMaths::Filmic;
  template <int W>
  static KN_INLINE Float<W> one(const Data& k, Float<W> x) {
    using F = Float<W>;
    // beyond 1e6 the curve is flat in single precision, its squares are not finite
    const F y = clamp(x * F(k.exposure), F(0.f), F(1e6f));
    const F above = fma(y, fma(y, F(k.a), F(k.cb)), F(k.de)), below = fma(y, fma(y, F(k.a), F(k.b)), F(k.df));
    return (above / below - F(k.ef)) * F(k.perWhite);
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(one(k, c.x), one(k, c.y), one(k, c.z)));
  }
};

struct WhitePointFilter {
  using Data = channelMaths::WhitePoint;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0)) return;
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(c.x * F(k.scale[0]), c.y * F(k.scale[1]), c.z * F(k.scale[2])));
  }
};

struct CopyFilter {
  using Data = channelMaths::Copy;
  template <int W>
  static KN_INLINE void filter(const Data&, const ChannelSpan<W>& s) {
    if (s.has(0) && s.has(1)) s.set(1, s.rgb(0));
  }
};

struct ShadowFilter {
  using Data = channelMaths::Shadow;
  template <int W>
  static KN_INLINE Float<W> one(const Data& k, Float<W> occluded, Float<W> unoccluded) {
    using F = Float<W>;
    const F least(k.threshold);
    return zeroUnless(unoccluded >= least, clamp(F(1.f) - occluded / max(unoccluded, least), F(0.f), F(1.f)));
  }
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    if (!s.has(0) || !s.has(1) || !s.has(2)) return;
    const Rgb<W> a = s.rgb(0), b = s.rgb(1);
    s.set(2, Rgb<W>(one(k, a.x, b.x), one(k, a.y, b.y), one(k, a.z, b.z)));
  }
};

struct BackgroundFilter {
  using Data = channelMaths::Background;
  template <int W>
  static KN_INLINE void filter(const Data& k, const ChannelSpan<W>& s) {
    using F = Float<W>;
    if (!s.has(0) || !s.has(1)) return;
    const F room = max(F(1.f) - s.number(1), F(0.f));
    const Rgb<W> c = s.rgb(0);
    s.set(0, Rgb<W>(fma(room, F(k.color[0]), c.x), fma(room, F(k.color[1]), c.y), fma(room, F(k.color[2]), c.z)));
    if (k.opacity != 0) s.set(1, fma(room, F(k.opacity), s.number(1)));
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
