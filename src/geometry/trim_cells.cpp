// How a cell that loops pass is cut: horizontal lines through every end and crossing of the pieces inside make slabs,
// in which pieces run from line to line and so bound trapezoids, every other of which is inside. A trapezoid becomes
// triangles around all points that it or a neighbour has on its sides. In a cell all is in whole numbers, 4096 to a
// side: what is left of what is decided exactly, and loops that cross, touch, overlap or run along the grid are no
// special cases.
#include "geometry/trim_cells.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace kinora::geometry {

using Imath::V2d;

namespace {

constexpr int kSteps = 4096;  // of a cell's side; even, so that the middle of a slab can be said in halves

// Bounds on what hostile loops may cost: some seconds.
constexpr size_t kMostPieces = 4'000'000;
constexpr size_t kMostPiecesOfCell = 4000;
constexpr int64_t kMostWork = 1'500'000'000;

struct Place {
  int u, v;
  bool operator==(const Place&) const = default;
};

// A part of a loop inside one cell, its lower end first.
struct Piece {
  int x, y;  // the cell
  Place a, b;
  bool onLine = false;  // runs up the cell's left side: bounds cells, but cuts none

  // Pieces that have equal order stand in one cell, or on one line.
  int order() const { return onLine ? 2 * x : 2 * x + 1; }
  bool covers(int doubleV) const { return 2 * a.v <= doubleV && doubleV < 2 * b.v; }
  // Where it crosses a horizontal line between its ends.
  int at(int v) const {
    if (v == a.v) return a.u;
    if (v == b.v) return b.u;
    return int(std::lround(a.u + double(b.u - a.u) * (v - a.v) / (b.v - a.v)));
  }
};

class TrimCutter {
 public:
  TrimCutter(bool keepInside, std::span<const double> u, std::span<const double> v)
      : keepInside_(keepInside), u_(u), v_(v), columns_(int(u.size()) - 1), rows_(int(v.size()) - 1) {}

  TrimmedCells run(const TrimLoops& loops);

 private:
  struct Wall {
    int low, high;  // where it meets the lines below and above
  };
  // A cell's pieces are cut at their crossings, its slabs known.
  struct Cell {
    std::vector<Piece> pieces;
    std::vector<int> lines;  // of the slabs, 0 and kSteps included
  };

  bool addSegment(const V2d& p, const V2d& q);
  void lookForCrossings();
  Place place(const V2d& p, int x, int y, int lineU, int lineV) const;
  static int cellOf(std::span<const double> lines, double x) {
    const int i = int(std::upper_bound(lines.begin(), lines.end(), x) - lines.begin()) - 1;
    return std::clamp(i, 0, int(lines.size()) - 2);
  }
  bool prepare(Cell& cell);
  void share(int x, int y, const Cell& cell);
  bool isOdd(size_t first, int y, int doubleV);
  void cut(int x, int y, const Cell& cell, size_t first);
  void whole(int x, int y, bool isInside);
  void polygon(int x, int y);
  V2d uv(int x, int y, const Place& p) const;

  // Points on the sides of cells besides their corners, by line and cell.
  using Sides = std::unordered_map<int64_t, std::vector<int>>;
  std::vector<int>& horizontal(int x, int line) { return horizontal_[int64_t(line) * columns_ + x]; }
  std::vector<int>& vertical(int line, int y) { return vertical_[int64_t(y) * (columns_ + 1) + line]; }
  static const std::vector<int>& of(const Sides& sides, int64_t key) {
    static const std::vector<int> kNone;
    const auto found = sides.find(key);
    return found == sides.end() ? kNone : found->second;
  }
  // Appends those strictly between two places, upwards or downwards.
  template <class Make>
  static void between(const std::vector<int>& points, int from, int to, std::vector<Place>& out, Make make) {
    if (from < to) {
      for (auto it = std::upper_bound(points.begin(), points.end(), from); it != points.end() && *it < to; ++it)
        out.push_back(make(*it));
    } else {
      auto it = std::lower_bound(points.begin(), points.end(), from);
      while (it != points.begin() && *(it - 1) > to) out.push_back(make(*--it));
    }
  }

  const bool keepInside_;
  const std::span<const double> u_, v_;
  const int columns_, rows_;
  std::vector<Piece> pieces_;  // by row and order
  std::vector<size_t> rowStart_;
  // Where segments meet lines of the grid, with their directions: two that cross right there have ends there alone.
  struct Meeting {
    int64_t place;
    float du, dv;
  };
  std::vector<Meeting> meetings_;
  Sides horizontal_, vertical_;
  int64_t work_ = 0;
  TrimmedCells out_;
  std::vector<Wall> walls_;
  std::vector<Place> corners_;
};

// Rounds a point that is known to lie in a cell, or on a line of the grid.
Place TrimCutter::place(const V2d& p, int x, int y, int lineU, int lineV) const {
  const auto round = [](std::span<const double> lines, int cell, int line, double at) {
    if (line >= 0) return line == cell ? 0 : kSteps;
    const double part = (at - lines[cell]) / (lines[cell + 1] - lines[cell]);
    return int(std::lround(std::clamp(part, 0.0, 1.0) * kSteps));
  };
  return {round(u_, x, lineU, p.x), round(v_, y, lineV, p.y)};
}

// Cuts a segment at the lines of the grid. What lies outside of the square is drawn to its border, which changes
// nothing inside.
bool TrimCutter::addSegment(const V2d& p, const V2d& q) {
  struct Stop {
    double t;
    int lineU, lineV;
  };
  std::vector<Stop> stops{{0, -1, -1}};
  const auto cross = [&](std::span<const double> lines, double a, double b, bool isU) {
    if (a == b) return;
    const double low = std::min(a, b), high = std::max(a, b);
    for (auto it = std::upper_bound(lines.begin(), lines.end(), low); it != lines.end() && *it < high; ++it) {
      const int line = int(it - lines.begin());
      stops.push_back({(*it - a) / (b - a), isU ? line : -1, isU ? -1 : line});
    }
  };
  cross(u_, p.x, q.x, true);
  cross(v_, p.y, q.y, false);
  std::sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.t < b.t; });
  stops.push_back({1, -1, -1});
  if (pieces_.size() + stops.size() > kMostPieces) return false;
  for (size_t k = 0; k + 1 < stops.size(); ++k) {
    const Stop &from = stops[k], &to = stops[k + 1];
    const V2d a = p + (q - p) * from.t, b = to.t == 1 ? q : p + (q - p) * to.t, middle = (a + b) * 0.5;
    const int x = cellOf(u_, middle.x), y = cellOf(v_, middle.y);
    constexpr size_t kMostMeetings = 500'000;
    if (k > 0 && meetings_.size() < kMostMeetings) {
      const bool isU = from.lineU >= 0;
      const Place at = place(a, x, y, -1, -1);
      const int64_t along = isU ? int64_t(y) * kSteps + at.v : int64_t(x) * kSteps + at.u;
      meetings_.push_back({(along * 2 + isU) * int64_t(1 << 20) + (isU ? from.lineU : from.lineV),
                           float((q.x - p.x) / (q - p).length()), float((q.y - p.y) / (q - p).length())});
    }
    // a stop at a line that is none of this cell's can only come from rounding
    const auto own = [](int line, int cell) { return line == cell || line == cell + 1 ? line : -1; };
    Piece piece{x, y, place(a, x, y, own(from.lineU, x), own(from.lineV, y)),
                place(b, x, y, own(to.lineU, x), own(to.lineV, y))};
    if (piece.a == piece.b) continue;
    if (piece.a.v > piece.b.v || (piece.a.v == piece.b.v && piece.a.u > piece.b.u)) std::swap(piece.a, piece.b);
    if (piece.a.v == piece.b.v && piece.a.v % kSteps == 0) continue;  // along a horizontal line: between two rows
    if (piece.a.u == piece.b.u && piece.a.u % kSteps == 0) {
      piece.x += piece.a.u / kSteps;
      piece.a.u = piece.b.u = 0;
      piece.onLine = true;
    }
    pieces_.push_back(piece);
  }
  return true;
}

void TrimCutter::lookForCrossings() {
  std::sort(meetings_.begin(), meetings_.end(), [](const Meeting& a, const Meeting& b) { return a.place < b.place; });
  for (size_t i = 1; i < meetings_.size(); ++i) {
    const Meeting &a = meetings_[i - 1], &b = meetings_[i];
    constexpr float kClearSine = 0.05f;  // less may be two that run side by side
    out_.crosses |= a.place == b.place && std::abs(a.du * b.dv - a.dv * b.du) > kClearSine;
  }
}

// False when the cell holds more than can be cut.
bool TrimCutter::prepare(Cell& cell) {
  std::vector<Piece>& pieces = cell.pieces;
  const size_t count = pieces.size();
  if (count > kMostPiecesOfCell) return false;
  work_ += int64_t(count) * int64_t(count);
  std::vector<std::pair<size_t, Place>> crossings;
  const auto side = [](const Place& a, const Place& b, const Place& p) {
    return int64_t(b.u - a.u) * (p.v - a.v) - int64_t(b.v - a.v) * (p.u - a.u);
  };
  for (size_t i = 0; i < count; ++i)
    for (size_t k = i + 1; k < count; ++k) {
      const Piece &p = pieces[i], &q = pieces[k];
      if (p.b.v < q.a.v || q.b.v < p.a.v) continue;
      const int64_t a = side(p.a, p.b, q.a), b = side(p.a, p.b, q.b), c = side(q.a, q.b, p.a),
                    d = side(q.a, q.b, p.b);
      if ((a > 0) == (b > 0) || (c > 0) == (d > 0) || a == 0 || b == 0 || c == 0 || d == 0) continue;
      const double t = double(a) / double(a - b);
      const Place at{int(std::lround(q.a.u + t * (q.b.u - q.a.u))), int(std::lround(q.a.v + t * (q.b.v - q.a.v)))};
      crossings.push_back({i, at});
      crossings.push_back({k, at});
      // rounding alone makes neighbours cross by a step or two
      const double lengthP = std::hypot(p.b.u - p.a.u, p.b.v - p.a.v);
      const double lengthQ = std::hypot(q.b.u - q.a.u, q.b.v - q.a.v);
      constexpr double kClear = 3;
      out_.crosses |= double(std::min(std::abs(a), std::abs(b))) > kClear * lengthP &&
                      double(std::min(std::abs(c), std::abs(d))) > kClear * lengthQ;
    }
  std::sort(crossings.begin(), crossings.end(), [](const auto& a, const auto& b) {
    return a.first != b.first         ? a.first < b.first
           : a.second.v != b.second.v ? a.second.v < b.second.v
                                      : a.second.u < b.second.u;
  });
  for (size_t c = 0; c < crossings.size();) {
    const size_t i = crossings[c].first;
    const Place end = pieces[i].b;
    Place from = pieces[i].a;
    bool isFirst = true;
    const auto add = [&](const Place& to) {
      Piece part = pieces[i];
      part.a = from;
      part.b = to;
      if (part.a.v > part.b.v) std::swap(part.a, part.b);
      from = to;
      if (isFirst)
        pieces[i] = part;
      else
        pieces.push_back(part);
      isFirst = false;
    };
    for (; c < crossings.size() && crossings[c].first == i; ++c) add(crossings[c].second);
    add(end);
  }
  cell.lines = {0, kSteps};
  for (const Piece& p : pieces)
    for (const int v : {p.a.v, p.b.v}) cell.lines.push_back(v);
  std::sort(cell.lines.begin(), cell.lines.end());
  cell.lines.erase(std::unique(cell.lines.begin(), cell.lines.end()), cell.lines.end());
  return true;
}

// Puts the points on a cell's sides where its neighbours find them.
void TrimCutter::share(int x, int y, const Cell& cell) {
  for (const Piece& p : cell.pieces)
    for (const Place& end : {p.a, p.b})
      if (end.v % kSteps == 0 && end.u % kSteps != 0) horizontal(x, y + end.v / kSteps).push_back(end.u);
  for (const int line : {x, x + 1}) {
    std::vector<int>& points = vertical(line, y);
    points.insert(points.end(), cell.lines.begin() + 1, cell.lines.end() - 1);
  }
}

// Whether a ray to the right from the left side of a cell, `doubleV` half steps up, meets the loops an odd number of
// times. `first` is the first piece of the row that does not lie to the left.
bool TrimCutter::isOdd(size_t first, int y, int doubleV) {
  bool odd = false;
  for (size_t i = first; i < rowStart_[size_t(y) + 1]; ++i) odd ^= pieces_[i].covers(doubleV);
  work_ += int64_t(rowStart_[size_t(y) + 1] - first);
  return odd;
}

V2d TrimCutter::uv(int x, int y, const Place& p) const {
  const auto at = [](std::span<const double> lines, int cell, int steps) {
    if (steps == 0) return lines[cell];
    if (steps == kSteps) return lines[cell + 1];
    return lines[cell] + (lines[cell + 1] - lines[cell]) * steps / kSteps;
  };
  return V2d(at(u_, x, p.u), at(v_, y, p.v));
}

// Triangles around corners_, which lie counter-clockwise on the outline of a convex shape.
void TrimCutter::polygon(int x, int y) {
  std::vector<Place>& p = corners_;
  p.erase(std::unique(p.begin(), p.end()), p.end());
  while (p.size() > 1 && p.front() == p.back()) p.pop_back();
  const size_t n = p.size();
  const auto area = [](const Place& a, const Place& b, const Place& c) {
    return int64_t(b.u - a.u) * (c.v - a.v) - int64_t(b.v - a.v) * (c.u - a.u);
  };
  int64_t all = 0;
  for (size_t i = 1; i + 1 < n; ++i) all += area(p[0], p[i], p[i + 1]);
  if (n < 3 || all <= 0) return;
  std::vector<V2d>& out = out_.triangles;
  const auto add = [&](size_t a, size_t b, size_t c) {
    for (const size_t k : {a, b, c}) out.push_back(uv(x, y, p[k % n]));
  };
  if (n == 3) return add(0, 1, 2);
  if (n == 4) {
    // a corner may lie on the way between its neighbours
    const int64_t first = std::min(area(p[0], p[1], p[2]), area(p[0], p[2], p[3]));
    const int64_t second = std::min(area(p[1], p[2], p[3]), area(p[1], p[3], p[0]));
    const size_t from = first >= second ? 0 : 1;
    add(from, from + 1, from + 2);
    return add(from, from + 2, from + 3);
  }
  V2d centre(0);
  for (const Place& corner : p) centre += uv(x, y, corner) / double(n);
  for (size_t i = 0; i < n; ++i) {
    out.push_back(uv(x, y, p[i]));
    out.push_back(uv(x, y, p[(i + 1) % n]));
    out.push_back(centre);
  }
}

void TrimCutter::cut(int x, int y, const Cell& cell, size_t first) {
  const std::vector<int>& lines = cell.lines;
  // all that anybody has on a line
  std::vector<std::vector<int>> points(lines.size());
  for (const Piece& p : cell.pieces) {
    size_t i = size_t(std::lower_bound(lines.begin(), lines.end(), p.a.v) - lines.begin());
    if (p.a.v == p.b.v)
      points[i].push_back(p.a.u), points[i].push_back(p.b.u);
    else
      for (; i < lines.size() && lines[i] <= p.b.v; ++i) points[i].push_back(p.at(lines[i]));
  }
  for (std::vector<int>& line : points) {
    std::sort(line.begin(), line.end());
    line.erase(std::unique(line.begin(), line.end()), line.end());
  }
  points.front() = of(horizontal_, int64_t(y) * columns_ + x);
  points.back() = of(horizontal_, int64_t(y + 1) * columns_ + x);
  const std::vector<int>& left = of(vertical_, int64_t(y) * (columns_ + 1) + x);
  const std::vector<int>& right = of(vertical_, int64_t(y) * (columns_ + 1) + x + 1);
  for (size_t i = 0; i + 1 < lines.size(); ++i) {
    const int low = lines[i], high = lines[i + 1];
    walls_.clear();
    for (const Piece& p : cell.pieces)
      if (p.a.v <= low && high <= p.b.v) walls_.push_back({p.at(low), p.at(high)});
    work_ += int64_t(cell.pieces.size());
    std::sort(walls_.begin(), walls_.end(), [](const Wall& a, const Wall& b) {
      return a.low + a.high != b.low + b.high ? a.low + a.high < b.low + b.high : a.low < b.low;
    });
    walls_.push_back({kSteps, kSteps});
    bool isInside = isOdd(first, y, low + high);
    Wall l{0, 0};
    for (Wall r : walls_) {
      // rounded walls may cross by a step
      r = {std::max(l.low, r.low), std::max(l.high, r.high)};
      if (isInside == keepInside_) {
        corners_.clear();
        corners_.push_back({l.low, low});
        between(points[i], l.low, r.low, corners_, [&](int u) { return Place{u, low}; });
        corners_.push_back({r.low, low});
        if (r.low == kSteps && r.high == kSteps)
          between(right, low, high, corners_, [&](int v) { return Place{kSteps, v}; });
        corners_.push_back({r.high, high});
        between(points[i + 1], r.high, l.high, corners_, [&](int u) { return Place{u, high}; });
        corners_.push_back({l.high, high});
        if (l.low == 0 && l.high == 0) between(left, high, low, corners_, [&](int v) { return Place{0, v}; });
        polygon(x, y);
      }
      isInside = !isInside;
      l = r;
    }
  }
}

// A cell that no loop passes: cut only where a neighbour has points on a common side.
void TrimCutter::whole(int x, int y, bool isInside) {
  const size_t cell = size_t(y) * size_t(columns_) + size_t(x);
  if (isInside != keepInside_) return;
  out_.kind[cell] = TrimmedCells::Whole;
  const std::vector<int>& bottom = of(horizontal_, int64_t(y) * columns_ + x);
  const std::vector<int>& top = of(horizontal_, int64_t(y + 1) * columns_ + x);
  const std::vector<int>& left = of(vertical_, int64_t(y) * (columns_ + 1) + x);
  const std::vector<int>& right = of(vertical_, int64_t(y) * (columns_ + 1) + x + 1);
  if (bottom.empty() && top.empty() && left.empty() && right.empty()) return;
  out_.kind[cell] = TrimmedCells::Cut;
  corners_.assign(1, {0, 0});
  between(bottom, 0, kSteps, corners_, [](int u) { return Place{u, 0}; });
  corners_.push_back({kSteps, 0});
  between(right, 0, kSteps, corners_, [](int v) { return Place{kSteps, v}; });
  corners_.push_back({kSteps, kSteps});
  between(top, kSteps, 0, corners_, [](int u) { return Place{u, kSteps}; });
  corners_.push_back({0, kSteps});
  between(left, kSteps, 0, corners_, [](int v) { return Place{0, v}; });
  polygon(x, y);
}

TrimmedCells TrimCutter::run(const TrimLoops& loops) {
  const auto giveUp = [&] {
    TrimmedCells none;
    none.tooMuch = true;
    return none;
  };
  for (const std::vector<V2d>& loop : loops)
    for (size_t i = 0; i < loop.size(); ++i)
      if (!addSegment(loop[i], loop[(i + 1) % loop.size()])) return giveUp();
  lookForCrossings();
  std::sort(pieces_.begin(), pieces_.end(),
            [](const Piece& a, const Piece& b) { return a.y != b.y ? a.y < b.y : a.order() < b.order(); });
  rowStart_.assign(size_t(rows_) + 1, 0);
  for (const Piece& p : pieces_) ++rowStart_[size_t(p.y) + 1];
  for (int y = 0; y < rows_; ++y) rowStart_[size_t(y) + 1] += rowStart_[size_t(y)];

  std::vector<Cell> cells;
  std::vector<size_t> cellStart;  // in pieces_
  for (size_t i = 0; i < pieces_.size();) {
    size_t end = i + 1;
    while (end < pieces_.size() && pieces_[end].y == pieces_[i].y && pieces_[end].order() == pieces_[i].order())
      ++end;
    if (!pieces_[i].onLine) {
      Cell cell;
      cell.pieces.assign(pieces_.begin() + std::ptrdiff_t(i), pieces_.begin() + std::ptrdiff_t(end));
      if (!prepare(cell) || work_ > kMostWork) return giveUp();
      share(pieces_[i].x, pieces_[i].y, cell);
      cells.push_back(std::move(cell));
      cellStart.push_back(i);
    }
    i = end;
  }
  for (Sides* sides : {&horizontal_, &vertical_})
    for (auto& [key, points] : *sides) {
      std::sort(points.begin(), points.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
    }

  out_.kind.assign(size_t(columns_) * size_t(rows_), TrimmedCells::Gone);
  std::vector<char> odd(static_cast<size_t>(columns_));
  size_t next = 0;  // of `cells`
  for (int y = 0; y < rows_; ++y) {
    bool isOddHere = false;
    size_t i = rowStart_[size_t(y) + 1];
    for (int x = columns_ - 1; x >= 0; --x) {
      for (; i > rowStart_[size_t(y)] && pieces_[i - 1].order() > 2 * x; --i)
        isOddHere ^= pieces_[i - 1].covers(kSteps + 1);
      odd[size_t(x)] = isOddHere;
    }
    for (int x = 0; x < columns_; ++x) {
      out_.first.push_back(uint32_t(out_.triangles.size() / 3));
      if (next < cells.size() && pieces_[cellStart[next]].x == x && pieces_[cellStart[next]].y == y) {
        out_.kind[size_t(y) * size_t(columns_) + size_t(x)] = TrimmedCells::Cut;
        cut(x, y, cells[next], cellStart[next]);
        ++next;
        if (work_ > kMostWork) return giveUp();
      } else {
        whole(x, y, odd[size_t(x)]);
      }
    }
  }
  out_.first.push_back(uint32_t(out_.triangles.size() / 3));
  return std::move(out_);
}

}  // namespace

TrimmedCells trimCells(const TrimLoops& loops, bool keepInside, std::span<const double> u,
                       std::span<const double> v) {
  return TrimCutter(keepInside, u, v).run(loops);
}

}  // namespace kinora::geometry
