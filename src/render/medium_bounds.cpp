#include "render/medium_bounds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "render/thread_groups.h"

namespace kinora::render {

namespace {

constexpr int kCells = 48;                // of bounds along the longest side
constexpr int kEmissionCells = 24;        // of emission
constexpr int kCoarse = 3, kFine = 6;     // points along a cell's side that are looked at
constexpr uint32_t kPointsAtOnce = 1024;  // of a context
// Optical thickness that a voxel of a coarser level may have. What gets through means of densities is less than the mean of
// what gets through, by half the variance of the thickness: at most 1 / 8 of the square of this where a voxel holds
// anything between nothing and that.
constexpr float kThickest = 0.25f;

// Cells of about the same sides, `most` along the longest of a box.
void cellsOf(const float low[3], const float high[3], int most, int cells[3]) {
  const float longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  for (int k = 0; k < 3; ++k)
    cells[k] = std::clamp(int(std::ceil(float(most) * (high[k] - low[k]) / longest)), 1, most);
}

// Points of a lattice that are looked at are spread over the shutter.
float timeOf(int point) { return 0.5f * float(point % 3); }

// Channels of the mean extinction over the largest of them, from those of all cells.
void setTint(shade::SpaceMedium& m, const std::vector<std::array<float, 3>>& means) {
  double sum[3] = {0, 0, 0}, whole = 0;
  for (size_t cell = 0; cell < means.size(); ++cell) {
    const std::array<float, 3>& x = means[cell];
    m.majorants.mean(cell) = std::max({x[0], x[1], x[2]});
    whole += double(m.majorants.mean(cell));
    for (int k = 0; k < 3; ++k) sum[k] += double(x[k]);
  }
  for (int k = 0; k < 3; ++k) m.tint[k] = whole > 0 ? float(sum[k] / whole) : 1.f;
}

// A bound that fields give within a cell, of what is looked up at a level of theirs.
float boundOf(const shade::SpaceMedium& m, const volume::Majorants& cells, size_t cell, uint32_t level) {
  float most = std::max({m.factor[0], m.factor[1], m.factor[2], 0.f}), low[3], high[3];
  cells.boundsOf(cell, low, high);
  // lookups round the corners of cells
  for (int k = 0; k < 3; ++k) {
    const float slack = 1e-4f * (high[k] - low[k]) + m.farthest[k];
    low[k] -= slack;
    high[k] += slack;
  }
  if (!(most < 1e30f)) most = 0;
  if (m.number) most *= std::max(m.number->most(low, high, level), 0.f);
  if (m.color) most *= std::max(m.color->most(low, high, level), 0.f);
  return most < 1e30f ? most * 1.00001f : 0.f;
}

// What a medium is over a lattice of n points along each side of the listed cells: put(cell, extinction, emission,
// count) of the points of one, each in arrays by channel. Emission is null where it is not wanted.
template <class Put>
void lookAt(const shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
            const volume::Majorants& grid, int n, const std::vector<uint32_t>& cells, bool wantsEmission,
            const std::atomic<bool>* stop, Put&& put) {
  const trace::Affine toRender = world.spaceOf(m.instance, m.geometry).fromRender.inverse();
  const size_t perCell = size_t(n) * size_t(n) * size_t(n);
  const size_t atOnce = std::max<size_t>(1, kPointsAtOnce / perCell);
  ThreadGroups groups(world);
  tbb::parallel_for(size_t(0), (cells.size() + atOnce - 1) / atOnce, [&](size_t chunk) {
    if (stop && stop->load(std::memory_order_relaxed)) return;
    const ThreadGroups::Use use(groups);
    Arena& arena = use.arena();
    const size_t first = chunk * atOnce, last = std::min(first + atOnce, cells.size());
    const uint32_t count = uint32_t((last - first) * perCell), room = padded(count);
    const auto f = [&] { return arena.make<float>(room); };
    float *P[3] = {f(), f(), f()}, *time = f(), *found[3] = {f(), f(), f()}, *glow[3] = {nullptr, nullptr, nullptr};
    if (wantsEmission)
      for (float*& x : glow) x = f();
    uint32_t at = 0;
    for (size_t c = first; c < last; ++c) {
      float from[3], to[3];
      grid.boundsOf(cells[c], from, to);
      for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x) {
            const int step[3] = {x, y, z};
            float p[3], q[3];
            for (int k = 0; k < 3; ++k) p[k] = from[k] + (to[k] - from[k]) * float(step[k]) / float(n - 1);
            toRender.point(p, q);
            for (int k = 0; k < 3; ++k) P[k][at] = q[k];
            time[at++] = m.isCarried ? timeOf(x + y + z) : 0.5f;
          }
    }
    use.group().lookUpMedium(index, count, P, time, found, glow);
    for (size_t c = first; c < last; ++c) {
      const size_t from = (c - first) * perCell;
      const float *const e[3] = {found[0] + from, found[1] + from, found[2] + from},
                         *const g[3] = {glow[0] ? glow[0] + from : nullptr, glow[0] ? glow[1] + from : nullptr,
                                        glow[0] ? glow[2] + from : nullptr};
      put(cells[c], e, g, perCell);
    }
  });
}

std::vector<uint32_t> allCells(const volume::Majorants& grid) {
  std::vector<uint32_t> cells(grid.count());
  std::iota(cells.begin(), cells.end(), 0u);
  return cells;
}

// f(cell, largest of it and its neighbours, smallest of those) for each cell.
template <class F>
void forNeighbourhoods(const volume::Majorants& m, const std::vector<float>& seen, F&& f) {
  const int c[3] = {m.cells(0), m.cells(1), m.cells(2)};
  for (int z = 0; z < c[2]; ++z)
    for (int y = 0; y < c[1]; ++y)
      for (int x = 0; x < c[0]; ++x) {
        float most = 0, least = INFINITY;
        for (int dz = std::max(z - 1, 0); dz <= std::min(z + 1, c[2] - 1); ++dz)
          for (int dy = std::max(y - 1, 0); dy <= std::min(y + 1, c[1] - 1); ++dy)
            for (int dx = std::max(x - 1, 0); dx <= std::min(x + 1, c[0] - 1); ++dx) {
              const float v = seen[(size_t(dz) * c[1] + dy) * c[0] + dx];
              most = std::max(most, v);
              least = std::min(least, v);
            }
        f((size_t(z) * c[1] + y) * c[0] + x, most, least);
      }
}

// What glows is met by rays even where it is clear: the more often the more it does, so that no few meetings bring all of
// its light; a little also where it was not seen to. side: of a cell, in render units.
void raiseBounds(shade::SpaceMedium& m, const volume::Majorants& grid, const std::vector<float>& emitted,
                 double side) {
  double sum = 0, squares = 0;
  float brightest = 0;
  for (const float e : emitted) {
    sum += double(e);
    squares += double(e) * double(e);
    brightest = std::max(brightest, e);
  }
  if (!(side > 0) || !(side < 1e30)) return;
  const double longest = side * std::max({grid.cells(0), grid.cells(1), grid.cells(2)});
  // as large, and as bright, as something even of the same power and the same mean square
  const double size = squares > 0 ? side * std::cbrt(sum * sum / squares) : longest,
               typical = sum > 0 ? squares / sum : 1;
  constexpr double kMeetings = 8, kMostMeetings = 32;
  for (size_t cell = 0; cell < m.majorants.count(); ++cell) {
    float from[3], to[3];
    m.majorants.boundsOf(cell, from, to);
    for (int k = 0; k < 3; ++k) from[k] = 0.5f * (from[k] + to[k]);
    const float here = m.majorants.count() > 1 ? emitted[grid.cellAt(from)] : brightest;
    const double meetings = std::min(kMeetings * double(here) / typical, kMostMeetings);
    const float least = float(meetings / size + 1 / longest);
    m.majorants[cell] = std::max(m.majorants[cell], least);
    for (shade::SpaceMedium::Level& level : m.levels) level.majorants[cell] = std::max(level.majorants[cell], least);
  }
}

}  // namespace

void makeBoundCells(shade::SpaceMedium& m) {
  float low[3], high[3];
  m.findReach(low, high);
  int cells[3] = {1, 1, 1};
  const bool isOne = m.isProduct && !m.number && !m.color && !m.isCarried;
  if (!isOne) cellsOf(low, high, kCells, cells);
  m.majorants = volume::Majorants(low, high, cells);
}

void boundByFields(shade::SpaceMedium& m) {
  std::vector<std::array<float, 3>> means(m.majorants.count());
  tbb::parallel_for(size_t(0), m.majorants.count(), [&](size_t cell) {
    constexpr int kPoints = 8;
    alignas(64) float low[3], high[3], place[3][kPad], extinction[3][kPad], time[kPad];
    const float* const P[3] = {place[0], place[1], place[2]};
    float* const found[3] = {extinction[0], extinction[1], extinction[2]};
    m.majorants.boundsOf(cell, low, high);
    for (int i = 0; i < int(kPad); ++i) {
      const int point = i % kPoints;
      for (int k = 0; k < 3; ++k) place[k][i] = low[k] + (high[k] - low[k]) * (point >> k & 1 ? 0.75f : 0.25f);
      time[i] = timeOf(point);
    }
    m.productsAt(8, kPoints, P, time, found);
    for (int k = 0; k < 3; ++k) {
      float sum = 0;
      for (int point = 0; point < kPoints; ++point) sum += extinction[k][point];
      means[cell][size_t(k)] = sum * (1.f / kPoints);
    }
    m.majorants[cell] = boundOf(m, m.majorants, cell, 0);
  });
  setTint(m, means);
}

void boundByShading(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
                    const std::atomic<bool>* stop) {
  std::vector<float> seen(m.majorants.count(), 0.f);
  std::vector<std::array<float, 3>> means(seen.size());
  std::vector<uint32_t> cells = allCells(m.majorants);
  const auto see = [&](uint32_t cell, const float* const extinction[3], const float* const[3], size_t count) {
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (size_t i = 0; i < count; ++i) {
        const float v = extinction[k][i];
        if (!(v < 1e30f)) continue;
        seen[cell] = std::max(seen[cell], v);
        sum += double(v);
      }
      means[cell][size_t(k)] = float(sum / double(count));
    }
  };
  lookAt(m, index, world, m.majorants, kCoarse, cells, false, stop, see);
  cells.clear();
  forNeighbourhoods(m.majorants, seen, [&](size_t cell, float most, float least) {
    if (most > 1.2f * least) cells.push_back(uint32_t(cell));
  });
  lookAt(m, index, world, m.majorants, kFine, cells, false, stop, see);
  setTint(m, means);
  constexpr float kMore = 1.15f;  // between the points of a lattice a pattern may be larger
  forNeighbourhoods(m.majorants, seen, [&](size_t cell, float most, float) { m.majorants[cell] = kMore * most; });
}

void setLevels(shade::SpaceMedium& m, float filterWidth, float scale) {
  if (!m.isProduct || !(filterWidth > 0)) return;
  uint32_t levels = 1;
  float side = 0;  // of a voxel
  for (const volume::MediumField* f : {m.number, m.color})
    if (f) {
      levels = std::max(levels, f->levels());
      side = std::max(side, f->voxelSize() * scale);
    }
  for (uint32_t level = 1; level < levels && side > 0 && side < 1e30f; ++level) {
    side *= 2;
    shade::SpaceMedium::Level next{0.5f * side / filterWidth, m.majorants};
    tbb::parallel_for(size_t(0), next.majorants.count(),
                      [&](size_t cell) { next.majorants[cell] = boundOf(m, next.majorants, cell, level); });
    if (!(next.majorants.largest() * side <= kThickest * std::max(filterWidth, 1.f))) break;
    m.levels.push_back(std::move(next));
  }
}

void findEmission(shade::SpaceMedium& m, uint32_t index, const shade::ShadingWorld& world,
                  const std::atomic<bool>* stop) {
  float low[3], high[3];
  m.findReach(low, high);
  int cells[3];
  cellsOf(low, high, kEmissionCells, cells);
  const volume::Majorants grid(low, high, cells);
  std::vector<float> own(grid.count(), 0.f), emitted(grid.count(), 0.f);
  lookAt(m, index, world, grid, kCoarse, allCells(grid), true, stop,
         [&](uint32_t cell, const float* const[3], const float* const emission[3], size_t count) {
           double sum = 0;
           for (int k = 0; k < 3; ++k)
             for (size_t i = 0; i < count; ++i) sum += double(emission[k][i]);
           own[cell] = float(sum / double(3 * count));
         });
  constexpr float kBeside = 0.15f;
  double total = 0;
  forNeighbourhoods(grid, own, [&](size_t cell, float most, float) {
    emitted[cell] = std::max(own[cell], kBeside * most);
    total += double(own[cell]);
  });
  float from[3], to[3];
  grid.boundsOf(0, from, to);
  // of a cell, in render units
  double volume = std::fabs(double(world.spaceOf(m.instance, m.geometry).fromRender.inverse().determinant()));
  for (int k = 0; k < 3; ++k) volume *= double(to[k] - from[k]);
  auto found = std::make_shared<const volume::EmissionCells>(low, high, cells, emitted);
  m.power = float(std::min(4 * 3.14159265358979 * total * volume, 1e24));
  if (!found->isBlack() && m.power > 0) m.emission = std::move(found);
  raiseBounds(m, grid, emitted, std::cbrt(volume));
}

}  // namespace kinora::render
