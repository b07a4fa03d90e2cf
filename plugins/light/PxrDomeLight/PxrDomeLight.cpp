// PxrDomeLight: light from all directions, constant or from a latitude-longitude map.
//
// Orientation. The native frame is Z-up. A direction (x, y, z) of the light's local space looks up the map at
//   u = -atan2(y, x) / (2 pi)  mod 1,   from the left edge,
//   v = acos(z) / pi,                   from the top edge:
// the top row is local +Z; the left edge is +X, a quarter in is -Y, the middle -X. Why: OpenEXR's latitude-longitude
// maps (which UsdLux follows) have the middle of the picture at +Z, the top at +Y, and at u = 1/4 the direction +X,
// that is u = 1/2 - atan2(X, Z) / (2 pi); and the host of UsdLux scenes turns a dome's axes x, y, z to (0,0,-1),
// (-1,0,0), (0,1,0). So X = -y, Y = z, Z = -x, and 1/2 - atan2(-y, -x) / (2 pi) is the formula above. Handedness:
// seen from the centre with +Z up, the right of the picture is clockwise from its left when looked at from above in a
// right-handed space, as a photograph has it; that host's turn has determinant +1, so a right-handed scene shows maps
// unmirrored. A left-handed scene shows them mirrored unless the placement mirrors too (Scale -1 1 1), which it may:
// rotation and mirroring of the placement count, scale and shear do not.
//
// Sampling: one cell a texel (or, in large maps, a block of texels), chosen by inversion of the rows' and then the
// row's distribution (searched in order: strata of the random numbers survive), evenly in solid angle within the
// cell. A cell's weight follows from the exact mean of the bilinear lookup over it (mis_compensation.h), so no direction
// has value without density.
#define KINORA_KERNEL_FILE "plugins/light/PxrDomeLight/PxrDomeLight.cpp"
#include <kinora/light_setup.h>
#include <algorithm>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/dome_map.h"
#include "plugins/light/parts/grey_sky.h"
#include "plugins/light/parts/mis_compensation.h"
#include "plugins/light/parts/sky_axes.h"
#include "plugins/light/parts/sky_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrDomeLight {
constexpr auto kParams = joinParams(lightParams::kRadiance, lightParams::kMap, lightParams::kControl);
// Cells in the distribution; finer maps are gathered into blocks. 2048 x 1024 cells are 17 MB of tables.
constexpr int32_t kMostColumns = 2048, kMostRows = 1024;

struct Data {
  LightCommon common;
  LightMap map;
  Float3 axis[3];  // local axes in render space: orthonormal, perhaps left-handed
  int32_t columns = 0, rows = 0;
  // Where the searches begin: each row's (and the rows') numbers in equal parts, a power of 2 of them; by part the
  // first cell that it may lie in, and above 16 bits the last one.
  int32_t rowParts = 1, columnParts = 1;
  std::vector<int32_t> rowGuide;   // rowParts
  std::vector<int32_t> cellGuide;  // rows times columnParts
  std::vector<float> rowCdf;       // rows + 1 numbers
  std::vector<float> cellCdf;      // rows times (columns + 1)
  std::vector<float> density;      // per solid angle, rows times columns
  // 1 - |cos| of the polar angle at each row's upper and lower edge, from the pole of the row's own hemisphere: sines
  // near both poles keep their digits so. The row across the equator belongs to the north and may go beyond 1.
  std::vector<float> rowFrom, rowTo;
  int32_t northRows = 0;
  double meanRadiance = 0;                       // over directions and RGB, absolute
  double sampledShare = lightParts::kKeptShare;  // of it: what samples are made for
  Double3 meanDirection;                         // towards the light, weighted by that
  bool isBlack = true;
};

constexpr double kPi = 3.14159265358979323846;

// A power of 2 near an eighth of the cells: tables an eighth as large, and few steps left.
int32_t partsFor(int32_t cells) {
  int32_t parts = 1;
  while (parts * 8 < cells) parts *= 2;
  return parts;
}
void appendGuide(const float* cdf, int32_t cells, int32_t parts, std::vector<int32_t>& guide) {
  static_assert(kMostColumns <= 0xffff && kMostRows <= 0xffff);
  int32_t at = 0;
  for (int32_t p = 0; p < parts; ++p) {
    const int32_t first = at;
    while (at + 1 < cells && cdf[at + 1] <= float(p + 1) / float(parts)) ++at;
    guide.push_back(first | at << 16);
  }
}

// Mean over each cell of the bilinear lookup's absolute value, averaged over RGB with the light's colour. Cells are
// texels or blocks of them; over a texel's own square the lookup is a mix of the 3 x 3 texels around it with weights
// 1/8, 6/8, 1/8 each way.
std::vector<double> cellMeans(const Data& k) {
  const int32_t w = k.map.width, h = k.map.height;
  std::vector<double> cells(size_t(k.columns) * k.rows, 0.0), row(static_cast<size_t>(w)),
      smooth(static_cast<size_t>(w));
  std::vector<double> three[3];
  const auto load = [&](int32_t y, std::vector<double>& out) {
    y = std::clamp(y, 0, h - 1);
    for (int32_t x = 0; x < w; ++x) {
      double sum = 0;
      for (int c = 0; c < 3; ++c) sum += std::fabs(k.common.radiance[c] * k.map.texel(size_t(y) * w + x, c)) / 3;
      row[size_t(x)] = sum;
    }
    out.resize(static_cast<size_t>(w));
    for (int32_t x = 0; x < w; ++x)
      out[size_t(x)] =
          0.125 * row[size_t((x + w - 1) % w)] + 0.75 * row[size_t(x)] + 0.125 * row[size_t((x + 1) % w)];
  };
  load(0, three[0]);
  load(0, three[1]);
  // A block's cell runs over [i * w / columns, (i + 1) * w / columns); texels that it shares with a neighbour count
  // for both in proportion.
  for (int32_t y = 0; y < h; ++y) {
    load(y + 1, three[2]);
    for (int32_t x = 0; x < w; ++x)
      smooth[size_t(x)] = 0.125 * three[0][size_t(x)] + 0.75 * three[1][size_t(x)] + 0.125 * three[2][size_t(x)];
    const double y0 = double(y) * k.rows / h, y1 = double(y + 1) * k.rows / h;
    for (int32_t j = int32_t(y0); j < k.rows && double(j) < y1 - 1e-9; ++j) {
      const double shareY = std::fmin(y1, j + 1.0) - std::fmax(y0, double(j));
      for (int32_t x = 0; x < w; ++x) {
        const double x0 = double(x) * k.columns / w, x1 = double(x + 1) * k.columns / w;
        for (int32_t i = int32_t(x0); i < k.columns && double(i) < x1 - 1e-9; ++i)
          cells[size_t(j) * k.columns + i] +=
              smooth[size_t(x)] * shareY * (std::fmin(x1, i + 1.0) - std::fmax(x0, double(i)));
      }
    }
    std::swap(three[0], three[1]);
    std::swap(three[1], three[2]);
  }
  return cells;
}

// False where the map is black altogether.
bool buildDistribution(Data& k) {
  k.columns = std::min(k.map.width, kMostColumns);
  k.rows = std::min(k.map.height, kMostRows);
  k.columnParts = partsFor(k.columns);
  k.rowParts = partsFor(k.rows);
  std::vector<double> cells = cellMeans(k);
  std::vector<double> rowWeight(size_t(k.rows), 0.0), solid(static_cast<size_t>(k.rows));
  for (int32_t j = 0; j < k.rows; ++j)
    solid[size_t(j)] = 2 * kPi / k.columns * (std::cos(kPi * j / k.rows) - std::cos(kPi * (j + 1) / k.rows));
  lightParts::Cells sphere{cells, solid, size_t(k.columns)};
  k.meanRadiance = sphere.mean();
  if (!(k.meanRadiance > 0) || !std::isfinite(k.meanRadiance)) return false;
  sphere.compensate(k.meanRadiance);
  Double3 mean;
  double total = 0;
  k.northRows = (k.rows + 1) / 2;
  for (int32_t j = 0; j < k.rows; ++j) {
    const bool north = j < k.northRows;
    const double from = kPi * (north ? j : k.rows - j) / k.rows, to = kPi * (north ? j + 1 : k.rows - j - 1) / k.rows;
    k.rowFrom.push_back(float(2 * std::pow(std::sin(from / 2), 2)));
    k.rowTo.push_back(float(2 * std::pow(std::sin(to / 2), 2)));
  }
  for (int32_t j = 0; j < k.rows; ++j) {
    const double polar = kPi * (j + 0.5) / k.rows;
    for (int32_t i = 0; i < k.columns; ++i) {
      const double weight = cells[size_t(j) * k.columns + i] * solid[size_t(j)];
      const double turn = -2 * kPi * (i + 0.5) / k.columns;
      mean = mean +
             Double3{std::cos(turn) * std::sin(polar), std::sin(turn) * std::sin(polar), std::cos(polar)} * weight;
      rowWeight[size_t(j)] += weight;
    }
    total += rowWeight[size_t(j)];
  }
  k.sampledShare = total / (4 * kPi * k.meanRadiance);
  k.meanDirection = lightParts::inRender(k.axis, mean * (1 / total));
  k.rowCdf.resize(size_t(k.rows) + 1);
  k.cellCdf.resize((size_t(k.columns) + 1) * k.rows);
  k.density.resize(cells.size());
  double below = 0;
  for (int32_t j = 0; j < k.rows; ++j) {
    k.rowCdf[size_t(j)] = float(below / total);
    below += rowWeight[size_t(j)];
    float* cdf = &k.cellCdf[size_t(j) * (size_t(k.columns) + 1)];
    double left = 0;
    for (int32_t i = 0; i < k.columns; ++i) {
      const double cell = cells[size_t(j) * k.columns + i];
      cdf[i] = rowWeight[size_t(j)] > 0 ? float(left * solid[size_t(j)] / rowWeight[size_t(j)])
                                        : float(i) / float(k.columns);
      left += cell;
      k.density[size_t(j) * k.columns + i] = float(cell / total);
    }
    cdf[k.columns] = 1;
    appendGuide(cdf, k.columns, k.columnParts, k.cellGuide);
  }
  k.rowCdf[size_t(k.rows)] = 1;
  appendGuide(k.rowCdf.data(), k.rows, k.rowParts, k.rowGuide);
  return true;
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->common = LightCommon::of(values, -1);
  light->map.load(values);
  lightParts::greySkyWithout(light->map, "lightColorMap", values, light->common);
  values.warnNoEffect();
  if (!lightParts::setSkyAxes(frame, light->axis)) {
    values.warn("LIGHT-DEGENERATE", "the light's transformation leaves it no directions", "the light is black");
    return light;
  }
  light->isBlack = light->common.isBlack();
  for (float c : light->common.radiance) light->meanRadiance += std::fabs(double(c)) / 3;
  if (light->map.valid() && !light->isBlack) light->isBlack = !buildDistribution(*light);
  return light;
}

void describe(const void* data, LightDescription* d) {
  const Data& k = *static_cast<const Data*>(data);
  *d = describeInfiniteLight(k.common, k.isBlack, 4 * kPi * k.meanRadiance);
  d->sampledShare = float(k.sampledShare);
  setAxis(*d, k.meanDirection);
}

// pi L for a constant dome; -1 for a map.
double irradiance(const void* data, const double*, const double*) {
  const Data& k = *static_cast<const Data*>(data);
  if (k.isBlack) return 0;
  if (k.map.valid()) return -1;
  return kPi * (double(k.common.radiance[0]) + k.common.radiance[1] + k.common.radiance[2]) / 3;
}
}  // namespace kinora::pxrDomeLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrDomeLight;

// Largest i with cdf[offset + i] <= u, for the part of the numbers that u lies in by `guide` a few steps away.
template <int W>
KN_INLINE Int<W> find(const float* cdf, Int<W> offset, const int32_t* guide, Int<W> guideOffset, int32_t parts,
                      Float<W> u) {
  using I = Int<W>;
  const I ends = gather(guide, guideOffset + toInt(u * Float<W>(float(parts))));
  I low = ends & I(0xffff), high = ends.template shr<16>() + I(1);  // the answer lies in [low, high)
  while ((high - low > I(1)).any()) {
    const I middle = (low + high).template shr<1>();
    const Mask<W> above = gather(cdf, offset + middle) <= u;
    low = select(above, middle, low);
    high = select(above, high, middle);
  }
  return low;
}

struct PxrDomeLight : DirectionalLight<PxrDomeLight, pxrDomeLight::Data> {
  // Radiance and density in one direction: sample, evaluate and emit all come here, so that they cannot disagree.
  template <int W>
  static KN_INLINE void at(const Data& k, Vec3<W> d, Rgb<W>& l, Float<W>& pdf) {
    using F = Float<W>;
    using I = Int<W>;
    l = wideRgb<W>(k.common.radiance);
    pdf = F(kInvFourPi);
    if (!k.map.valid()) return;
    F u, v;
    toDomeMap(toSky<W>(k.axis, d), u, v);
    l = l * lookUp<W, true>(k.map, u, v);
    const F none(0.f);
    const I column = toInt(clamp(u * F(float(k.columns)), none, F(float(k.columns - 1))));
    const I row = toInt(clamp(v * F(float(k.rows)), none, F(float(k.rows - 1))));
    pdf = gather(k.density.data(), row * I(k.columns) + column);
  }
  template <int W>
  static KN_INLINE Vec3<W> direction(const Data& k, Float<W> u, Float<W> v) {
    using F = Float<W>;
    using I = Int<W>;
    if (!k.map.valid()) return uniformSphere(u, v);
    const I row = find<W>(k.rowCdf.data(), I(0), k.rowGuide.data(), I(0), k.rowParts, v);
    const F r0 = gather(k.rowCdf.data(), row), r1 = gather(k.rowCdf.data(), row + I(1));
    const F down = clamp((v - r0) / max(r1 - r0, F(1e-30f)), F(0.f), F(1.f));
    const I start = row * I(k.columns + 1);
    const I column = find<W>(k.cellCdf.data(), start, k.cellGuide.data(), row * I(k.columnParts), k.columnParts, u);
    const F c0 = gather(k.cellCdf.data(), start + column), c1 = gather(k.cellCdf.data(), start + column + I(1));
    const F across = clamp((u - c0) / max(c1 - c0, F(1e-30f)), F(0.f), F(1.f));
    // evenly in the cosine
    const F fromPole = lerp(gather(k.rowFrom.data(), row), gather(k.rowTo.data(), row), down);
    const F z = select(toFloat(row) < F(float(k.northRows)), F(1.f) - fromPole, fromPole - F(1.f));
    const F s = safeSqrt(fromPole * (F(2.f) - fromPole));
    F sine, cosine;
    sincos((toFloat(column) + across) * F(-kTwoPi / float(k.columns)), sine, cosine);
    return normalize(fromSky<W>(k.axis, Vec3<W>(s * cosine, s * sine, z)));
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(
    PxrDomeLight,
    .help =
        "Light from all around, constant or a latitude-longitude map. Z-up: the map's top is local +Z, its left edge "
        "+X, its middle -X, a quarter from the left -Y. Only rotation and mirroring of the placement count.",
    .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
