// IesLightFilter: a measured light distribution, candelas by two angles about the light's +z axis. The renderer makes
// one of each light's iesProfile; scenes may give its tables themselves.
#define KINORA_KERNEL_FILE "plugins/lightfilter/IesLightFilter/IesLightFilter.cpp"
#include <memory>
#include <vector>

#include "plugins/lightfilter/parts/filter_setup.h"
// per target from here
#include <kinora/light_filter_author.h>
#include <kinora/math/elementary.h>

#include "plugins/lightfilter/parts/filter_kernels.h"

#if KINORA_PLAIN
namespace kinora::iesLightFilter {
using namespace filterParts;
enum Web : int { kC, kB, kA };
constexpr float kVertical[] = {0, 90}, kHorizontal[] = {0}, kCandela[] = {1, 0};
constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr auto kParams = joinParams(
    std::array{
        param::integer("webType", kC)
            .range(0, 2)
            .options("0 C, 1 B, 2 A")
            .help("What the angles are. C: vertical from +z, horizontal about it from +x to +y. B: vertical the turn "
                  "about x from +z to +y, horizontal the elevation towards +x. A: vertical the elevation towards +y, "
                  "horizontal the turn about y from +z to +x."),
        param::array(Type::Float, "verticalAngles", kVertical, 2)
            .help("Degrees, ascending; nothing shines beyond them."),
        param::array(Type::Float, "horizontalAngles", kHorizontal, 1)
            .help(
                "Degrees, ascending: one (alike all around), 0 to 360 for type C, within -90 and 90 for the others."),
        param::array(Type::Float, "candela", kCandela, 2)
            .help("For each horizontal angle the values at its vertical ones."),
        param::number("scale", 0.f).range(-0.9f, 1).help("Widens all angles to +z by this part of them."),
        param::integer("normalize", 0)
            .options("0 the largest factor is 1, 1 the mean factor over all directions is 1")
            .help("What the values are divided by."),
    },
    kStrength);

struct Data {
  FilterSpace space;
  int web;
  bool isScaled;
  float perScale, density, most;
  std::vector<float> vertical, horizontal, factor;
};

// The interval of an angle and the part of the way through it; false outside of the list.
bool find(const std::vector<float>& list, double x, size_t& at, double& part) {
  if (x < list.front() || x > list.back()) return false;
  at = size_t(std::upper_bound(list.begin(), list.end(), float(x)) - list.begin());
  at = std::min(std::max(at, size_t(1)), list.size() - 1) - 1;
  part = (x - list[at]) / (double(list[at + 1]) - list[at]);
  return true;
}

// Mean over all directions, by midpoints of equal solid angles; the tables are piecewise linear.
double meanOf(const Data& k) {
  constexpr int kRings = 1024, kSteps = 256;
  const size_t rows = k.vertical.size();
  double sum = 0;
  for (int i = 0; i < kRings; ++i) {
    double theta = std::acos(1 - 2 * (i + 0.5) / kRings) * k.perScale;
    if (theta > 3.14159265358979323846) break;
    for (int j = 0; j < kSteps; ++j) {
      const double phi = (j + 0.5) / kSteps * 2 * 3.14159265358979323846;
      const double x = std::sin(theta) * std::cos(phi), y = std::sin(theta) * std::sin(phi), z = std::cos(theta);
      const double v = k.web == kC ? theta : k.web == kB ? std::atan2(y, z) : std::asin(y);
      const double h = k.web == kC ? phi : k.web == kB ? std::asin(x) : std::atan2(x, z);
      size_t row = 0, column = 0;
      double dv = 0, dh = 0;
      if (!find(k.vertical, v * kDegrees, row, dv)) continue;
      if (k.horizontal.size() > 1 && !find(k.horizontal, h * kDegrees, column, dh)) continue;
      const float* a = k.factor.data() + column * rows + row;
      const float* b = k.horizontal.size() > 1 ? a + rows : a;
      sum += (a[0] + (a[1] - a[0]) * dv) * (1 - dh) + (b[0] + (b[1] - b[0]) * dv) * dh;
    }
  }
  return sum / (double(kRings) * kSteps);
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues v(info, kParams.data(), kParams.size());
  auto k = std::make_unique<Data>();
  // angles are those between the axes, whatever their lengths; the main one is a flat light's normal
  const LocalFrame frame = LocalFrame::of(info);
  const Double3 across = cross(frame.x, frame.y);
  if (!(length(across) > 1e-30)) throw "the light's transformation is flat";
  const double side = dot(across, frame.z) < 0 ? -1 : 1;
  const Double3 z = normalized(across) * side, x = normalized(frame.x), y = cross(z, x) * side;
  k->space.x = Float3(x);
  k->space.y = Float3(y);
  k->space.z = Float3(z);
  const auto list = [&](const char* name, std::vector<float>& to) {
    const ParamValue& p = info.values[v.index(name)];
    to.assign(p.floats, p.floats + p.count);
    for (float x : to)
      if (!(std::fabs(x) < 1e30f)) throw "the tables hold numbers that are not finite";
  };
  list("verticalAngles", k->vertical);
  list("horizontalAngles", k->horizontal);
  list("candela", k->factor);
  if (k->vertical.size() < 2 || k->horizontal.empty() ||
      k->factor.size() != k->vertical.size() * k->horizontal.size())
    throw "there are not as many values as angles, or fewer than two vertical ones";
  for (const auto* angles : {&k->vertical, &k->horizontal})
    for (size_t i = 1; i < angles->size(); ++i)
      if (!((*angles)[i] > (*angles)[i - 1])) throw "the angles do not ascend";
  k->web = std::clamp(v.integer("webType"), 0, 2);
  const double scale = std::max(1 + v.number("scale"), 1e-3);
  k->isScaled = scale != 1;
  k->perScale = float(1 / scale);
  k->density = strength(v);
  double most = 0;
  for (float& f : k->factor) most = std::max(most, double(f = std::max(f, 0.f)));
  if (!(most > 0)) throw "no value is above 0";
  for (float& f : k->factor) f = float(f / most);
  k->most = 1;
  if (v.integer("normalize")) {
    const double mean = meanOf(*k);
    if (!(mean > 1e-9)) throw "it shines nowhere";
    for (float& f : k->factor) f = float(f / mean);
    k->most = float(1 / mean);
  }
  v.warnNoEffect();
  return k;
}
float largest(const void* data) { return largestOf(static_cast<const Data*>(data)->most); }
}  // namespace kinora::iesLightFilter
#endif

KINORA_KERNELS_BEGIN
using namespace iesLightFilter;

// The interval of an angle that lies in the list, by halving.
template <int W>
KN_INLINE Int<W> intervalOf(const std::vector<float>& list, Float<W> x, Float<W>& part) {
  using F = Float<W>;
  using I = Int<W>;
  const float* angles = list.data();
  I low(0);
  uint32_t step = 1;
  while (step < list.size()) step *= 2;
  const I last(int32_t(list.size()) - 2);
  for (; step > 0; step /= 2) {
    const I next = low + I(int32_t(step));
    const Mask<W> there = !(next > last);
    const Mask<W> up = there & (x >= gather(angles, select(there, next, low)));
    low = select(up, next, low);
  }
  const F a = gather(angles, low), b = gather(angles, low + I(1));
  part = clamp((x - a) / (b - a), F(0.f), F(1.f));
  return low;
}

struct IesLightFilter {
  using Data = iesLightFilter::Data;
  template <int W>
  static KN_INLINE Rgb<W> factor(const Data& k, const LitPoint<W>& p) {
    using F = Float<W>;
    using I = Int<W>;
    constexpr float kToDegrees = 57.29577951f;
    const Vec3<W> d = normalize(directionIn<W>(k.space, -p.wi));
    const F aside = sqrt(fma(d.x, d.x, d.y * d.y));
    F theta = atan2(aside, d.z);
    Mask<W> shines(true);
    Vec3<W> at = d;
    if (k.isScaled) {
      theta = theta * F(k.perScale);
      shines = theta <= F(kPi);
      F s, c;
      sincos(min(theta, F(kPi)), s, c);
      const F turn = s / max(aside, F(1e-12f));
      at = Vec3<W>(d.x * turn, d.y * turn, c);
    }
    F v, h;
    if (k.web == kC) {
      v = theta;
      h = atan2(at.y, at.x);
      h = select(h < F(0.f), h + F(2 * kPi), h);
    } else if (k.web == kB) {
      v = atan2(at.y, at.z);
      h = asin(clamp(at.x, F(-1.f), F(1.f)));
    } else {
      v = asin(clamp(at.y, F(-1.f), F(1.f)));
      h = atan2(at.x, at.z);
    }
    v = v * F(kToDegrees);
    h = h * F(kToDegrees);
    const F slack(1e-4f);  // of rounding, in degrees
    shines &= (v >= F(k.vertical.front()) - slack) & (v <= F(k.vertical.back()) + slack);
    F dv, dh(0.f);
    const I row = intervalOf<W>(k.vertical, v, dv);
    I a = row, b = row;
    if (k.horizontal.size() > 1) {
      shines &= (h >= F(k.horizontal.front()) - slack) & (h <= F(k.horizontal.back()) + slack);
      const I rows(int32_t(k.vertical.size())), column = intervalOf<W>(k.horizontal, h, dh);
      a = column * rows + row;
      b = a + rows;
    }
    const float* table = k.factor.data();
    const F f = lerp(lerp(gather(table, a), gather(table, a + I(1)), dv),
                     lerp(gather(table, b), gather(table, b + I(1)), dv), dh);
    const F shining = zeroUnless(shines, f);
    return filtered<W>(Rgb<W>(shining, shining, shining), F(k.density));
  }
};
KINORA_KERNELS_END

KINORA_LIGHT_FILTER(IesLightFilter, .help = "A measured light distribution; made of each light's iesProfile.",
                    .params = kParams, .setUp = setUpBy<make>, .largest = largest)
