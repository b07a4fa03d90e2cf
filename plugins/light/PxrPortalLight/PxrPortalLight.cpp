// PxrPortalLight: the part of a dome that is seen through a rectangle. It emits what the dome has in each direction
// through it, and is sampled by that (portal_table.h): from each point the directions through the rectangle have the
// density of the map there. Where the placement shears it, where it shows less than a quarter of a cell of the table, and
// where the dome is even, it is sampled as PxrRectLight is. The renderer gives it the scene's dome where the file does not
// say which one (render/portals.h), and that dome then shines through its portals alone. Where dome and portal turn against
// each other while the shutter is open, each sample sees the dome of its time, and the table is the mean over that time:
// all times share a density, which has a floor in every cell.
#define KINORA_KERNEL_FILE "plugins/light/PxrPortalLight/PxrPortalLight.cpp"
#include <kinora/light_setup.h>
#include <cmath>
#include <memory>
#include <vector>
#include <kinora/light_author.h>

#include "plugins/light/PxrPortalLight/portal_table.h"
#include "plugins/light/parts/dome_map.h"
#include "plugins/light/parts/grey_sky.h"
#include "plugins/light/parts/rectangle_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrPortalLight {
constexpr float kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr std::array kPortal = {
    param::string("domeColorMap", "")
        .file()
        .help("The dome's latitude-longitude map; empty: that of the scene's dome, or none."),
    lightParams::kMap[1],  // colorMapGamma
    lightParams::kMap[2],  // colorMapSaturation
    param::array(Type::Float, "portalToDome", kIdentity, 16)
        .help("Matrix from the portal's local space to the dome's, row-vector; rotation and mirroring count. As a "
              "matrix or 16 numbers."),
    param::array(Type::Float, "domeTurns", nullptr, 0)
        .help("How the dome turns against the portal while the shutter is open, which the renderer says of the "
              "scene's dome: unit quaternions (w, x, y, z) at even times over the shutter, world space, from "
              "directions through the portal in the middle of that time to those by which the dome, as portalToDome "
              "has it, is looked up. Empty: it does not."),
    param::number("intensityMult", 1.f).range(0, 10).help("Factor on the dome's radiance."),
    param::color("tint", 1.f).help("Factor on the dome's colour."),
    param::string("portalName", "").help("Accepted: tells portals apart for the host that writes them."),
};
constexpr auto kParams = joinParams(lightParams::kRadiance, kPortal, lightParams::kControl);

struct Data : lightParts::Rectangle {
  Float3 domeX, domeY, domeZ;             // the dome's local axes in render space: orthonormal, perhaps left-handed
  lightParts::PortalTable seen, emitted;  // radiance, and times the cosine; without a map, and where sheared, none
  std::vector<float> turns;               // domeTurns, neighbours on one side; none without a map
  int32_t lastTurn = 0;                   // of them
};

// Leaves none, with a message, where they are no turns.
void setTurns(const NamedValues& values, const ParamValue& given, Data& k) {
  bool areTurns = given.count % 4 == 0 && given.count != 4;
  for (uint32_t i = 0; i < given.count && areTurns; i += 4) {
    double length2 = 0, along = 0;
    for (uint32_t c = 0; c < 4; ++c) {
      length2 += double(given.floats[i + c]) * given.floats[i + c];
      if (i > 0) along += double(given.floats[i + c]) * k.turns[i + c - 4];
    }
    areTurns = length2 > 1e-12 && std::isfinite(length2);
    const double scale = (along < 0 ? -1 : 1) / std::sqrt(length2);
    for (uint32_t c = 0; c < 4 && areTurns; ++c) k.turns.push_back(float(given.floats[i + c] * scale));
  }
  if (!areTurns) {
    values.warn("LIGHT-PORTAL", "domeTurns are not two or more quaternions", "the dome does not turn");
    k.turns.clear();
  }
  if (!k.map.valid()) k.turns.clear();
  k.lastTurn = std::max(int32_t(k.turns.size() / 4) - 1, 0);
}

// The dome's axes at `time` (0..1 over the shutter), in the space in which the portal rests: those at rest, turned back.
lightParts::PortalTable::Axes domeAt(const Data& k, double time) {
  const auto wide = [](const Float3& a) { return normalized({a.x, a.y, a.z}); };
  lightParts::PortalTable::Axes dome{wide(k.domeX), wide(k.domeY), wide(k.domeZ)};
  if (k.turns.empty()) return dome;
  const double place = time * k.lastTurn, from = std::fmin(std::floor(place), k.lastTurn - 1.0);
  const float* turn = &k.turns[4 * size_t(from)];
  double q[4], length2 = 0;
  for (int c = 0; c < 4; ++c) {
    q[c] = turn[c] + (turn[c + 4] - double(turn[c])) * (place - from);
    length2 += q[c] * q[c];
  }
  const double scale = 1 / std::sqrt(length2);
  const Double3 back{-q[1] * scale, -q[2] * scale, -q[3] * scale};
  for (Double3* axis : {&dome.x, &dome.y, &dome.z}) {
    const Double3 t = cross(back, *axis) * 2;
    *axis = normalized(*axis + t * (q[0] * scale) + cross(back, t));
  }
  return dome;
}

// The matrix's rows are the portal's axes as the dome has them; their lengths, the portal's size, say nothing of
// directions. False where nothing is left of these.
bool setDomeAxes(const LocalFrame& f, const float* toDome, Data& k) {
  const Double3 local[3] = {normalized(f.x), normalized(f.y), normalized(f.z)};
  Double3 axis[3];
  for (int i = 0; i < 3; ++i) {
    const Double3 row = normalized({toDome[4 * i], toDome[4 * i + 1], toDome[4 * i + 2]});
    const double parts[3] = {row.x, row.y, row.z};
    for (int j = 0; j < 3; ++j) axis[j] = axis[j] + local[i] * parts[j];
  }
  for (Double3& a : axis) a = normalized(a);
  const Double3 z = axis[2], y = normalized(axis[1] - z * dot(axis[1], z));
  Double3 x = cross(y, z);
  if (dot(x, axis[0]) < 0) x = x * -1;
  k.domeX = Float3(x);
  k.domeY = Float3(y);
  k.domeZ = Float3(z);
  return length(z) > 0.5 && length(y) > 0.5 && std::fabs(dot(x, axis[0])) > 1e-6;
}

// Radians of all the way.
double angleOf(const std::vector<float>& turns) {
  double angle = 0;
  for (size_t i = 4; i < turns.size(); i += 4) {
    double along = 0;
    for (size_t c = 0; c < 4; ++c) along += double(turns[i + c]) * turns[i + c - 4];
    angle += 2 * std::acos(std::fmin(1, along));
  }
  return angle;
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->common = LightCommon::of(values, -1);
  for (int c = 0; c < 3; ++c)
    light->common.radiance[c] *= float(values.number("intensityMult") * values.number("tint", c));
  light->map.load(values, "domeColorMap");
  lightParts::greySkyWithout(light->map, "domeColorMap", values, light->common);
  values.warnNoEffect();
  light->place(values, frame);
  if (!(light->area > 0)) return light;
  const ParamValue& matrix = info.values[values.index("portalToDome")];
  bool isMatrix = matrix.count == 16;
  for (uint32_t i = 0; i < matrix.count && isMatrix; ++i) isMatrix = std::isfinite(matrix.floats[i]);
  if (!setDomeAxes(frame, isMatrix ? matrix.floats : kIdentity, *light) || !isMatrix) {
    values.warn("LIGHT-PORTAL", "portalToDome is no matrix that turns", "the dome stands as the portal does");
    if (!setDomeAxes(frame, kIdentity, *light)) light->isBlack = true;
  }
  setTurns(values, info.values[values.index("domeTurns")], *light);
  if (!light->isBlack && light->map.valid() && light->isRectangle) {
    const auto wide = [](const Float3& a) { return normalized({a.x, a.y, a.z}); };
    lightParts::PortalTable::Setup setup{&light->map,
                                         wide(light->unitX),
                                         wide(light->unitY),
                                         light->normal64,
                                         {},
                                         light->common.radiance,
                                         lightParts::PortalTable::sizeFor(light->map)};
    const double angle = angleOf(light->turns);
    const int32_t times = angle > 0 ? lightParts::PortalTable::timesFor(angle, setup.size) : 1;
    for (int32_t k = 0; k < times; ++k) setup.domes.push_back(domeAt(*light, (k + 0.5) / times));
    double mean[3];
    lightParts::PortalTable::build(setup, light->seen, light->emitted, mean);
    std::copy(mean, mean + 3, light->map.mean);  // of what passes the portal, for its share among the lights
  }
  return light;
}

void describe(const void* data, LightDescription* d) { *d = lightParts::describe(*static_cast<const Data*>(data)); }
// Of an even dome; -1 where a map makes the radiance vary.
double irradiance(const void* data, const double P[3], const double N[3]) {
  return lightParts::irradiance(*static_cast<const Data*>(data), P, N);
}
}  // namespace kinora::pxrPortalLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrPortalLight;

// A window of a table: the cells [x0, x0 + width] x [y0, y0 + height], whole and in part.
template <int W>
struct PortalWindow {
  using F = Float<W>;
  using I = Int<W>;
  const int32_t* sums;
  const I stride;
  I i0, i1, j0, j1;            // first and last cells
  F fx0, fx1, fy0, fy1;        // where the window begins in the first and ends in the last ones
  I low0, low1, high0, high1;  // sums at i0, of the four corners along y
  F total;

  KN_INLINE PortalWindow(const lightParts::PortalTable& t, F x0, F y0, F width, F height)
      : sums(t.sums()), stride(t.size() + 1) {
    begin(t.size(), x0, width, i0, i1, fx0, fx1);
    begin(t.size(), y0, height, j0, j1, fy0, fy1);
    const I row = i0 * stride + j0, last = i0 * stride + j1;
    low0 = gather(sums, row);
    low1 = gather(sums, row + I(1));
    high0 = gather(sums, last);
    high1 = gather(sums, last + I(1));
    const F end = before(i1);
    total = fma(fx1, before(i1 + I(1)) - end, end) - fx0 * before(i0 + I(1));
  }
  // All of the table.
  explicit KN_INLINE PortalWindow(const lightParts::PortalTable& t)
      : sums(t.sums()),
        stride(t.size() + 1),
        i0(0),
        i1(t.size() - 1),
        j0(0),
        j1(t.size() - 1),
        fx0(0.f),
        fx1(1.f),
        fy0(0.f),
        fy1(1.f),
        low0(0),
        low1(0),
        high0(0),
        high1(0),
        total(t.whole()) {}
  static KN_INLINE void begin(int32_t size, F from, F extent, I& first, I& last, F& begins, F& ends) {
    const F highest(float(size - 1)), none(0.f), one(1.f);
    const F low = clamp(floor(from), none, highest);
    begins = clamp(from - low, none, one);
    const F high = clamp(floor(begins + extent), none, highest - low);
    ends = clamp(begins + extent - high, none, one);
    first = toInt(low);
    last = first + toInt(high);
  }
  // Of the columns [i0, i) between the window's ends along y. Differences of sums are exact before they are rounded.
  KN_INLINE F before(I i) const {
    const I row = i * stride, l0 = gather(sums, row + j0) - low0, l1 = gather(sums, row + j0 + I(1)) - low1,
            h0 = gather(sums, row + j1) - high0, h1 = gather(sums, row + j1 + I(1)) - high1;
    // rows between the first and the last; less the first where these are one
    return fma(fy1, toFloat(h1 - h0), fnma(fy0, toFloat(l1 - l0), toFloat(h0 - l0)));
  }
  // Of the rows [j0, j) of a column.
  KN_INLINE F below(I i, I j) const {
    const I a = i * stride, b = a + stride;
    return toFloat((gather(sums, b + j) - gather(sums, b + j0)) - (gather(sums, a + j) - gather(sums, a + j0)));
  }
  KN_INLINE F cell(I i, I j) const {
    const I a = i * stride + j, b = a + stride;
    return toFloat((gather(sums, b + I(1)) - gather(sums, b)) - (gather(sums, a + I(1)) - gather(sums, a)));
  }
  // The last of [lo, hi] whose sum() is not above the target.
  template <class Sum>
  static KN_INLINE I find(I lo, I hi, F target, Sum sum) {
    while (true) {
      const Mask<W> open = lo < hi;
      if (open.none()) return lo;
      const I middle = (lo + hi + I(1)).template shr<1>();
      const Mask<W> up = sum(middle) <= target;
      hi = select(open & !up, middle - I(1), hi);
      lo = select(open & up, middle, lo);
    }
  }
  // Cells from the window's corner, and the density by cells.
  KN_INLINE void sample(F u, F v, F& x, F& y, F& density) const {
    const F none(0.f), one(1.f);
    F target = fma(u, total, fx0 * before(i0 + I(1)));
    const I i = find(i0, i1, target, [&](I at) HWY_ATTR { return before(at); });
    const F left = before(i), column = before(i + I(1)) - left;
    x = clamp((target - left) / max(column, F(1e-20f)), select(i == i0, fx0, none), select(i == i1, fx1, one));
    x = x + toFloat(i - i0) - fx0;
    const F first = fy0 * cell(i, j0), all = fma(fy1, cell(i, j1), below(i, j1)) - first;
    target = fma(v, all, first);
    const I j = find(j0, j1, target, [&](I at) HWY_ATTR { return below(i, at); });
    const F here = cell(i, j);
    y = clamp((target - below(i, j)) / here, select(j == j0, fy0, none), select(j == j1, fy1, one));
    y = y + toFloat(j - j0) - fy0;
    density = here / total;
  }
  // By cells, at so many from the window's corner.
  KN_INLINE F densityAt(F x, F y) const {
    const I none(0);
    I i = toInt(max(x + fx0, F(0.f))), j = toInt(max(y + fy0, F(0.f)));
    i = select(i > i1 - i0, i1 - i0, select(i < none, none, i));
    j = select(j > j1 - j0, j1 - j0, select(j < none, none, j));
    return cell(i0 + i, j0 + j) / total;
  }
};

// The window through which a point sees the dome. Directions are told by their parts along the portal's axes and towards
// it, or points of its plane by the same relative to the point.
template <int W>
struct PortalView {
  using F = Float<W>;
  F z, x0, y0;       // distance of the plane; angles of the corner
  F perCell, cells;  // radians, and their inverse
  F width, height;   // in cells
  Mask<W> usable;
  KN_INLINE PortalView(const lightParts::PortalTable& t, const SphericalRectangle<W>& r, Mask<W> isRectangle) {
    z = sqrt(max(r.z0 * r.z0, F(1e-30f)));
    perCell = F(kPi / float(t.size()));
    cells = F(float(t.size()) * kInvPi);
    x0 = atan(r.x0 / z);
    y0 = atan(r.y0 / z);
    width = cells * atan2(z * (r.x1 - r.x0), fma(z, z, r.x0 * r.x1));
    height = cells * atan2(z * (r.y1 - r.y0), fma(z, z, r.y0 * r.y1));
    usable = isRectangle & r.front & (min(width, height) > F(0.25f));
  }
  KN_INLINE PortalWindow<W> window(const lightParts::PortalTable& t) const {
    const F half(0.5f * float(t.size()));
    return PortalWindow<W>(t, fma(x0, cells, half), fma(y0, cells, half), width, height);
  }
  KN_INLINE F across(F x) const { return (atan(x / z) - x0) * cells; }
  KN_INLINE F up(F y) const { return (atan(y / z) - y0) * cells; }
};

// Solid angle of a square radian of the table's angles, inverse: x, y along the axes, z towards the portal, of a unit
// direction.
template <int W>
KN_INLINE Float<W> bySolidAngle(Float<W> x, Float<W> y, Float<W> z) {
  using F = Float<W>;
  const F z2 = max(z * z, F(1e-30f)), x2 = x * x, y2 = y * y;
  return fnma(x2 / (x2 + z2), y2 / (y2 + z2), F(1.f)) / max(z, F(1e-15f));
}

struct PxrPortalLight {
  using Data = pxrPortalLight::Data;
  static constexpr bool kIntersects = true;
  template <int W>
  using Lanes = RectangleLanes<Data, W>;
  struct Plain : RectangleLight<PxrPortalLight, Data> {};

  template <int W>
  static KN_INLINE Rgb<W> radiance(const Lanes<W>& k, Vec3<W> wi, Float<W>, Float<W>, Float<W>) {
    const Rgb<W> l = k.of.rgb([](const Data& d) { return d.common.radiance; });
    if (!k.of.any([](const Data& d) { return d.map.valid(); })) return l;
    Float<W> u, v;
    toDomeMap(Vec3<W>(dot(wi, k.of(&Data::domeX)), dot(wi, k.of(&Data::domeY)), dot(wi, k.of(&Data::domeZ))), u, v);
    return l * lookUp<W, true>(k.of, u, v);
  }

  // Where the dome at rest has what is seen along wi at that time.
  template <int W>
  static KN_INLINE Vec3<W> turned(const Data& light, Vec3<W> wi, Float<W> time) {
    using F = Float<W>;
    using I = Int<W>;
    const F place = clamp(time, F(0.f), F(1.f)) * F(float(light.lastTurn));
    const I last(light.lastTurn - 1);
    I from = toInt(place);
    from = select(from < I(0), I(0), select(from > last, last, from));  // whatever lanes without a time hold
    const F b = place - toFloat(from), a = F(1.f) - b;
    const I at = from * I(4);
    F q[4];
    for (int c = 0; c < 4; ++c)
      q[c] = fma(a, gather(light.turns.data() + c, at), b * gather(light.turns.data() + 4 + c, at));
    const F scale = F(1.f) / sqrt(fma(q[0], q[0], fma(q[1], q[1], fma(q[2], q[2], q[3] * q[3]))));
    const Vec3<W> axis = Vec3<W>(q[1], q[2], q[3]) * scale, t = cross(axis, wi) * F(2.f);
    return fma(t, q[0] * scale, wi + cross(axis, t));
  }
  template <int W>
  static KN_INLINE Rgb<W> radianceAt(const Lanes<W>& k, const Data& light, Vec3<W> wi, Float<W> time) {
    return radiance<W>(k, light.turns.empty() ? wi : turned<W>(light, wi, time), time, time, time);
  }

  template <int W>
  static KN_INLINE void sample(const Data& light, const LightPoint<W>& in, LightSample<W>& out) {
    using F = Float<W>;
    const LightOf<Data, W> of(light);
    Plain::template sample<W>(of, in, out);
    if (light.isBlack) return;
    if (!light.turns.empty()) out.radiance = radianceAt<W>(Lanes<W>(of), light, out.wi, in.time);
    if (!light.seen.valid()) return;
    const Lanes<W> k(of);
    const SphericalRectangle<W> r(k, in.P);
    const PortalView<W> view(light.seen, r, k.isRectangle);
    if (view.usable.none()) return;
    F x, y, density;
    view.window(light.seen).sample(in.u, in.v, x, y, density);
    x = clamp(view.z * tan(fma(x, view.perCell, view.x0)), r.x0, r.x1);
    y = clamp(view.z * tan(fma(y, view.perCell, view.y0)), r.y0, r.y1);
    LightSample<W> s;
    const F distance = sqrt(fma(x, x, fma(y, y, view.z * view.z))), inverse = F(1.f) / distance;
    s.wi = fma(k.unitX, x, fma(k.unitY, y, k.normal * -view.z)) * inverse;
    s.distance = distance;
    s.pdf = density * (view.cells * view.cells) * bySolidAngle(x * inverse, y * inverse, view.z * inverse);
    s.radiance = radianceAt<W>(k, light, s.wi, in.time);
    s.delta = Mask<W>(false);
    out = select(view.usable, s, out);
  }

  template <int W>
  static KN_INLINE Mask<W> intersect(const Data& light, Vec3<W> o, Vec3<W> d, Float<W>& t) {
    return Plain::template intersect<W>(LightOf<Data, W>(light), o, d, t);
  }

  template <int W>
  static KN_INLINE void evaluate(const Data& light, const LightRay<W>& ray, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    const LightOf<Data, W> of(light);
    Plain::template evaluate<W>(of, ray, l, pdf);
    if (light.isBlack) return;
    const Mask<W> hit = pdf > F(0.f);
    if (hit.none()) return;
    const Lanes<W> k(of);
    if (!light.turns.empty()) l = zeroUnless(hit, radianceAt<W>(k, light, ray.d, ray.time));
    if (!light.seen.valid()) return;
    const PortalView<W> view(light.seen, SphericalRectangle<W>(k, ray.o), k.isRectangle);
    if ((hit & view.usable).none()) return;
    const F x = dot(ray.d, k.unitX), y = dot(ray.d, k.unitY), z = max(-dot(ray.d, k.normal), F(1e-15f));
    const F t = view.z / z;
    const F density = view.window(light.seen).densityAt(view.across(x * t), view.up(y * t));
    pdf = select(hit & view.usable, density * (view.cells * view.cells) * bySolidAngle(x, y, z), pdf);
  }

  // From every point of the portal all of the table's directions.
  template <int W>
  static KN_INLINE void emit(const Data& light, const EmitInput<W>& in, LightEmission<W>& out) {
    using F = Float<W>;
    const LightOf<Data, W> of(light);
    Plain::template emit<W>(of, in, out);
    if (light.isBlack) return;
    if (!light.turns.empty()) out.radiance = radianceAt<W>(Lanes<W>(of), light, -out.d, in.time);
    if (!light.emitted.valid()) return;
    const Lanes<W> k(of);
    const F n(float(light.emitted.size())), perCell = F(kPi) / n;
    F x, y, density;
    PortalWindow<W>(light.emitted).sample(in.u2, in.u3, x, y, density);
    F sx, cx, sy, cy;  // of angles from the edge, a quarter turn below the table's
    sincos(x * perCell, sx, cx);
    sincos(y * perCell, sy, cy);
    // tangents are -c / s
    const Vec3<W> towards = fma(k.unitX, -cx * sy, fma(k.unitY, -cy * sx, k.normal * (-sx * sy)));
    const F size = length(towards);
    const Vec3<W> wi = towards * (F(1.f) / max(size, F(1e-15f)));
    out.d = -wi;
    out.pdfDirection =
        density * (n * n * F(kInvPi * kInvPi)) * bySolidAngle(dot(wi, k.unitX), dot(wi, k.unitY), -dot(wi, k.normal));
    out.radiance = radianceAt<W>(k, light, wi, in.time);
  }

  template <int W>
  static KN_INLINE void densities(const Data& light, const LightRay<W>& ray, LightDensities<W>& out) {
    using F = Float<W>;
    const LightOf<Data, W> of(light);
    Plain::template densities<W>(of, ray, out);
    if (light.isBlack || !light.emitted.valid()) return;
    const Lanes<W> k(of);
    const F x = dot(ray.d, k.unitX), y = dot(ray.d, k.unitY), z = -dot(ray.d, k.normal);
    const F n(float(light.emitted.size())), cells = n * F(kInvPi), half = n * F(0.5f), least(1e-15f);
    const F across = fma(atan(x / max(z, least)), cells, half), up = fma(atan(y / max(z, least)), cells, half);
    const F density = PortalWindow<W>(light.emitted).densityAt(across, up);
    out.pdfDirection = zeroUnless(z > F(0.f), density * (cells * cells) * bySolidAngle(x, y, z));
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(
    PxrPortalLight,
    .help =
        "The part of a dome that is seen through a rectangle, the unit square of the local XY plane, which "
        "lights the side of local +Z. Without parameters of its own it shows the scene's dome, which then "
        "shines through its portals alone. Sampled by what each point sees of the map through the rectangle.",
    .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
