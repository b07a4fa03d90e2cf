#include <kinora/channel_filter.h>
#include <kinora/light_filter.h>
#include <kinora/pixel_filter.h>
#include <kinora/testing/filter_checks.h>
#include <kinora/testing/setting.h>
#include <kinora/volume.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>

#include "testing/bound_bxdf.h"
#include "testing/displacement_checks.h"
#include "testing/judge.h"

namespace kinora::testing {

namespace {

constexpr uint32_t kPoints = 37, kRows = 14;
constexpr uint32_t kColumns = 64, kLines = 48;  // of the picture that channel filters work on

// Inputs of all points, row by row, and their answers; `order` says which point stands where.
struct Batch {
  std::vector<float> in, out;
  std::vector<int32_t> x, y;
  float* row(std::vector<float>& v, uint32_t r) const { return v.data() + size_t(r) * padded(kPoints); }
};

float hashed(uint64_t seed, uint32_t row, uint32_t point) {
  uint64_t z = seed * 0x9E3779B97F4A7C15u + (uint64_t(row) << 32 | point);  // splitmix64 (Vigna)
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return float((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

Batch makeBatch(uint64_t seed, const std::vector<uint32_t>& order) {
  Batch b;
  const uint32_t n = padded(kPoints);
  b.in.resize(size_t(n) * kRows);
  b.out.assign(size_t(n) * kRows, 0.f);
  b.x.resize(n);
  b.y.resize(n);
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t p = order[std::min(i, kPoints - 1)];
    for (uint32_t r = 0; r < kRows; ++r) b.row(b.in, r)[i] = 6 * hashed(seed, r, p) - 2;
    float* d[3] = {b.row(b.in, 3), b.row(b.in, 4), b.row(b.in, 5)};  // rows 3 to 5 are a direction
    const float l = std::sqrt(d[0][i] * d[0][i] + d[1][i] * d[1][i] + d[2][i] * d[2][i]);
    for (float* c : d) c[i] = l > 1e-3f ? c[i] / l : c == d[2];
    b.row(b.in, 6)[i] = p % 5 == 4 ? INFINITY : 0.1f + 5 * hashed(seed, 6, p);  // a distance
    b.row(b.in, 7)[i] = hashed(seed, 7, p);                                     // a time, an alpha
    b.x[i] = int32_t(p * 7 % kColumns);
    b.y[i] = int32_t(p * 3 % kLines);
  }
  return b;
}

uint32_t runChannels(const Descriptor& d, const void* functions, const void* data, Batch& b) {
  const auto* traits = static_cast<const ChannelFilterTraits*>(d.traits);
  FilterChannel list[16];
  uint32_t n = 0, rows = 0;
  b.out = b.in;
  static const std::vector<float> picture = [] {
    std::vector<float> v(size_t(kRows) * kColumns * kLines);
    for (uint32_t r = 0; r < kRows; ++r)
      for (uint32_t i = 0; i < kColumns * kLines; ++i) v[size_t(r) * kColumns * kLines + i] = 6 * hashed(7, r, i) - 2;
    return v;
  }();
  for (const char* name; n < 16 && rows + 3 <= kRows && (name = traits->channel(data, n)); ++n) {
    const bool isFloat = std::strlen(name) == 1;  // "a", "z"
    list[n] = {name, isFloat ? 1u : 3u, {}, {}};
    for (uint32_t c = 0; c < list[n].components; ++c, ++rows) {
      list[n].data[c] = b.row(b.out, rows);
      if (traits->seesPicture) list[n].before[c] = picture.data() + size_t(rows) * kColumns * kLines;
    }
  }
  const ChannelFilterArgs a{kPoints, b.x.data(), b.y.data(), list, n, {0, 0, int32_t(kColumns), int32_t(kLines)}};
  if (d.kind == Kind::SampleFilter)
    static_cast<const SampleFilterFunctions*>(functions)->filter(data, &a);
  else
    static_cast<const DisplayFilterFunctions*>(functions)->filter(data, &a);
  return rows;
}

// Rows of answers.
uint32_t run(const Descriptor& d, const void* functions, const void* data, Batch& b) {
  switch (d.kind) {
    case Kind::LightFilter: {
      const LightFilterArgs a{kPoints,
                              {b.row(b.in, 0), b.row(b.in, 1), b.row(b.in, 2)},
                              {b.row(b.in, 3), b.row(b.in, 4), b.row(b.in, 5)},
                              b.row(b.in, 6),
                              b.row(b.in, 7),
                              {b.row(b.out, 0), b.row(b.out, 1), b.row(b.out, 2)}};
      static_cast<const LightFilterFunctions*>(functions)->factor(data, &a);
      return 3;
    }
    case Kind::Volume: {
      const auto* traits = static_cast<const VolumeTraits*>(d.traits);
      uint32_t rows = 0;
      for (uint32_t f = 0; traits && f < traits->fieldCount && rows + 3 <= kRows; ++f, rows += 3) {
        const VolumeArgs a{kPoints,
                           {b.row(b.in, 0), b.row(b.in, 1), b.row(b.in, 2)},
                           b.row(b.in, 7),
                           f,
                           {b.row(b.out, rows), b.row(b.out, rows + 1), b.row(b.out, rows + 2)}};
        static_cast<const VolumeFunctions*>(functions)->evaluate(data, &a);
      }
      return rows;
    }
    case Kind::PixelFilter:
      for (uint32_t i = 0; i < kPoints; ++i)
        b.row(b.out, 0)[i] = float(static_cast<const PixelFilterFunctions*>(functions)->value(
            data, b.row(b.in, 0)[i] / 4, b.row(b.in, 1)[i] / 4));
      return 1;
    default:
      return runChannels(d, functions, data, b);
  }
}

}  // namespace

bool hasFilterChecks(Kind kind) {
  return kind == Kind::SampleFilter || kind == Kind::DisplayFilter || kind == Kind::LightFilter ||
         kind == Kind::PixelFilter || kind == Kind::Volume || kind == Kind::Displacement;
}

CheckReport checkFilter(const Descriptor& d, uint64_t seed) {
  if (d.kind == Kind::Displacement) return checkDisplacement(d, seed);
  const auto start = std::chrono::steady_clock::now();
  CheckReport report;
  report.plugin = d.name;
  const auto fail = [&](const char* check, const std::string& setting, const std::string& what) {
    noteFailure(report, check, setting, what);
  };
  const auto tables = runnableTables(d);
  const bool needsTraits = d.kind == Kind::SampleFilter || d.kind == Kind::DisplayFilter || d.kind == Kind::Volume;
  if (!hasFilterChecks(d.kind) || tables.empty() || !d.create || !d.destroy || (needsTraits && !d.traits)) {
    fail("usable", "", "no functions, no create() and destroy(), or no traits");
    return report;
  }
  std::vector<uint32_t> order(kPoints), reversed(kPoints);
  for (uint32_t i = 0; i < kPoints; ++i) order[i] = i, reversed[i] = kPoints - 1 - i;
  Placement placement{};
  const double turned[16] = {0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 0.5, -1, 0.25, 1};
  std::copy_n(turned, 16, placement.localToRender);
  placement.isStatic = 1;
  Host host{};
  host.warn = [](void*, const char*, const char*, const char*) {};
  host.image = [](void*, const char*, int) -> const HostImage* { return nullptr; };
  const PixelFilterInfo width{{2, 2}};
  const ChannelFilterInfo picture{{kColumns, kLines}, 1};
  const void* extra = d.kind == Kind::PixelFilter ? static_cast<const void*>(&width)
                      : d.kind == Kind::SampleFilter || d.kind == Kind::DisplayFilter ? &picture
                                                                                      : nullptr;
  uint32_t made = 0;
  for (const Setting& s : coveringSettings(d, 64, seed)) {
    ++report.settings;
    const ResolvedValues values(d, s);
    const CreateInfo info{&host, "under test", values.data(), values.count(), &placement, extra};
    ErrorText error{};
    void* data = d.create(&info, &error);
    if (!data) {  // a setting may be refused, with a reason
      if (!error.text[0]) fail("create", s.text, "refused without a reason");
      continue;
    }
    ++made;
    Batch first = makeBatch(seed, order);
    uint32_t rows = 0;
    for (size_t t = 0; t < tables.size(); ++t) {
      Batch b = makeBatch(seed, order), back = makeBatch(seed, reversed);
      rows = run(d, tables[t]->functions, data, b);
      run(d, tables[t]->functions, data, back);
      if (t == 0) first = b;
      for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t i = 0; i < kPoints; ++i) {
          const float v = b.row(b.out, r)[i];
          report.comparisons += 3;
          const std::string where = "width " + std::to_string(tables[t]->width) + ", point " + std::to_string(i);
          if (!std::isfinite(v)) fail("finite", s.text, where + " gives " + std::to_string(v));
          if (d.kind == Kind::LightFilter && v < 0) fail("negative", s.text, where + " gives " + std::to_string(v));
          if (std::memcmp(&v, &first.row(first.out, r)[i], sizeof v) != 0)
            fail("widths", s.text, where + " differs from width " + std::to_string(tables[0]->width));
          if (std::memcmp(&v, &back.row(back.out, r)[kPoints - 1 - i], sizeof v) != 0)
            fail("neighbours", s.text, where + " depends on where the point stands");
        }
    }
    if (const auto* traits =
            d.kind == Kind::LightFilter ? static_cast<const LightFilterTraits*>(d.traits) : nullptr) {
      const bool uniform = traits->isUniform && traits->isUniform(data);
      const float largest = traits->largest ? traits->largest(data) : INFINITY;
      for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t i = 0; i < kPoints; ++i) {
          const float v = first.row(first.out, r)[i];
          if (uniform && v != first.row(first.out, r)[0]) fail("uniform", s.text, "calls itself uniform and is not");
          if (v > largest * 1.000001f) fail("largest", s.text, "a factor is larger than the largest");
        }
    }
    d.destroy(data);
  }
  if (!made) fail("create", "all", "no setting can be made");
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace kinora::testing
