#include "light/ies_profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace kinora::light {

namespace {

// The numbers of a file, however they are broken into lines.
class Numbers {
 public:
  Numbers(std::string_view text, size_t at, uint32_t line) : text_(text), at_(at), line_(line) {}

  double number(const char* what) {
    if (!error.what.empty()) return 0;
    skip();
    const char* from = text_.data() + at_;
    const char* end = text_.data() + text_.size();
    const char* first = from < end && *from == '+' ? from + 1 : from;
    double value = 0;
    const auto [to, problem] = std::from_chars(first, end, value);
    if (at_ >= text_.size()) return fail(std::string("the file ends where ") + what + " should be");
    if (problem != std::errc() || !std::isfinite(value) || std::fabs(value) > 1e30 || (to < end && !isBetween(*to)))
      return fail(std::string(what) + " is no number");
    at_ += size_t(to - from);
    return value;
  }
  int count(const char* what, int least, int most) {
    const double x = number(what);
    if (!error.what.empty()) return 0;
    if (!(x >= least && x <= most) || x != std::floor(x)) {
      fail(std::string(what) + " is not a whole number from " + std::to_string(least) + " to " +
           std::to_string(most));
      return 0;
    }
    return int(x);
  }
  double fail(std::string what) {
    if (error.what.empty()) error = {std::max(line_, 1u), std::move(what)};
    return 0;
  }
  size_t left() const { return text_.size() - at_; }
  bool ok() const { return error.what.empty(); }

  IesError error;

 private:
  static bool isBetween(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }
  void skip() {
    for (; at_ < text_.size() && isBetween(text_[at_]); ++at_) line_ += text_[at_] == '\n';
  }
  std::string_view text_;
  size_t at_;
  uint32_t line_;
};

using Columns = std::vector<std::pair<float, size_t>>;  // an angle, and the file's column for it

void unfold(IesProfile& p, const Columns& columns) {
  const size_t rows = p.vertical.size();
  std::vector<float> candela;
  candela.reserve(columns.size() * rows);
  p.horizontal.clear();
  for (const auto& [angle, from] : columns) {
    p.horizontal.push_back(angle);
    candela.insert(candela.end(), p.candela.begin() + std::ptrdiff_t(from * rows),
                   p.candela.begin() + std::ptrdiff_t((from + 1) * rows));
  }
  p.candela = std::move(candela);
}

// Files from 90 to 270 are alike on both sides of the plane through these: where 180 is not among their angles, neither
// would 0 be, and the way around would have a gap.
void completeHalf(IesProfile& p) {
  std::vector<float>& h = p.horizontal;
  if (p.type != IesType::C || h.size() < 2 || h.front() != 90 || h.back() != 270) return;
  const auto above = std::lower_bound(h.begin(), h.end(), 180.f);
  if (*above == 180) return;
  const auto i = size_t(above - h.begin()), rows = p.vertical.size();
  const float f = (180 - h[i - 1]) / (h[i] - h[i - 1]);
  std::vector<float> between(rows);
  for (size_t k = 0; k < rows; ++k)
    between[k] = p.candela[(i - 1) * rows + k] * (1 - f) + p.candela[i * rows + k] * f;
  p.candela.insert(p.candela.begin() + std::ptrdiff_t(i * rows), between.begin(), between.end());
  h.insert(above, 180.f);
}

// The columns of all angles by the symmetry that the file's have; "" or what is wrong with them.
std::string unfoldedColumns(const IesProfile& p, Columns& columns) {
  const std::vector<float>& h = p.horizontal;
  if (h.size() == 1) {
    columns.emplace_back(0.f, 0);
    return "";
  }
  const float first = h.front(), last = h.back();
  const auto add = [&](float angle, size_t from) {
    if (columns.empty() || columns.back().first != angle) columns.emplace_back(angle, from);
  };
  const auto forward = [&](float start, float sign) {  // start + sign * angle, in the order of the file
    for (size_t i = 0; i < h.size(); ++i) add(start + sign * h[i], i);
  };
  const auto backward = [&](float start, float sign) {
    for (size_t i = h.size(); i-- > 0;) add(start + sign * h[i], i);
  };
  if (p.type != IesType::C) {
    if (first < -90 || last > 90) return "horizontal angles of this type lie within -90 and 90";
    if (first == 0) backward(0, -1);
    forward(0, 1);
  } else if (first == 0 && last == 90) {
    forward(0, 1);
    backward(180, -1);
    forward(180, 1);
    backward(360, -1);
  } else if (first == 0 && last == 180) {
    forward(0, 1);
    backward(360, -1);
  } else if (first == 90 && last == 270) {  // alike on both sides of the plane through 90 and 270
    for (size_t i = h.size(); i-- > 0;)
      if (h[i] <= 180) add(180 - h[i], i);
    forward(0, 1);
    for (size_t i = h.size(); i-- > 0;)
      if (h[i] >= 180) add(540 - h[i], i);
  } else if (first == 0 && last > 180 && last <= 360) {
    forward(0, 1);
    add(360, 0);  // files that leave the way back out
  } else {
    return "horizontal angles go from " + std::to_string(int(first)) + " to " + std::to_string(int(last)) +
           ": not from 0 to 90, 180 or 360, nor from 90 to 270";
  }
  return "";
}

}  // namespace

IesError readIes(std::string_view text, IesProfile& profile) {
  profile = {};
  if (text.size() > kMostIesBytes) return {1, "the file is larger than 16 MiB"};
  // Labels or keywords, up to the line that begins with TILT.
  size_t at = 0;
  uint32_t line = 1;
  std::string_view tilt;
  for (;; ++line) {
    if (at >= text.size()) return {line, "no line begins with TILT="};
    const size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view all = text.substr(at, end - at);
    at = std::min(end + 1, text.size());
    if (all.substr(0, 5) != "TILT=") continue;
    tilt = all.substr(5);
    break;
  }
  while (!tilt.empty() && (tilt.back() == '\r' || tilt.back() == ' ' || tilt.back() == '\t')) tilt.remove_suffix(1);
  while (!tilt.empty() && (tilt.front() == ' ' || tilt.front() == '\t')) tilt.remove_prefix(1);
  Numbers in(text, at, line + 1);
  // How lamps dim when they are tilted says nothing of the shape of their light.
  if (tilt == "INCLUDE") {
    in.number("the lamp's place in its housing");
    const int n = in.count("the count of tilts", 0, 10000);
    for (int i = 0; i < 2 * n && in.ok(); ++i) in.number("a tilt");
  }
  in.number("the count of lamps");
  in.number("the lumens of a lamp");
  const double multiplier = in.number("the candela multiplier");
  const int vertical = in.count("the count of vertical angles", 2, int(kMostIesValues));
  const int horizontal = in.count("the count of horizontal angles", 1, int(kMostIesValues));
  const int type = in.count("the photometric type", 1, 3);
  in.count("the type of units", 1, 2);
  for (const char* size : {"the width", "the length", "the height"}) in.number(size);
  const double ballast = in.number("the ballast factor");
  in.number("the number behind the ballast factor");
  in.number("the input watts");
  if (in.ok() && !(multiplier * ballast > 0)) in.fail("candela multiplier and ballast factor are not positive");
  const uint64_t values = uint64_t(vertical) * uint64_t(horizontal);
  // each number takes a character and one between
  if (in.ok() && (values > kMostIesValues || values + uint64_t(vertical) + uint64_t(horizontal) > in.left() / 2 + 1))
    in.fail(std::to_string(vertical) + " x " + std::to_string(horizontal) + " values are announced, which the file " +
            "cannot hold");
  if (!in.ok()) return in.error;

  const auto angles = [&](std::vector<float>& list, int count, const char* what) {
    list.resize(size_t(count));
    for (size_t i = 0; i < list.size() && in.ok(); ++i) {
      list[i] = float(in.number(what));
      if (in.ok() && std::fabs(list[i]) > 360) in.fail(std::string(what) + " is beyond 360");
      if (in.ok() && i && !(list[i] > list[i - 1])) in.fail(std::string(what) + " is not larger than the one before");
    }
  };
  profile.type = type == 1 ? IesType::C : type == 2 ? IesType::B : IesType::A;
  angles(profile.vertical, vertical, "a vertical angle");
  if (in.ok()) {
    const float least = profile.type == IesType::C ? 0.f : -90.f, most = profile.type == IesType::C ? 180.f : 90.f;
    if (profile.vertical.front() < least || profile.vertical.back() > most)
      in.fail("vertical angles lie within " + std::to_string(int(least)) + " and " + std::to_string(int(most)));
  }
  angles(profile.horizontal, horizontal, "a horizontal angle");
  Columns columns;
  if (in.ok())
    if (std::string wrong = unfoldedColumns(profile, columns); !wrong.empty()) in.fail(std::move(wrong));
  profile.candela.resize(in.ok() ? size_t(values) : 0);
  bool shines = false;
  for (float& c : profile.candela) {
    if (!in.ok()) break;
    const double value = in.number("a candela value") * multiplier * ballast;
    if (in.ok() && !(value >= 0 && value < 1e30)) in.fail("a candela value is negative or too large");
    c = float(value);
    shines |= c > 0;
  }
  if (in.ok() && !shines) in.fail("all candela values are 0");
  if (!in.ok()) return in.error;
  completeHalf(profile);
  columns.clear();
  unfoldedColumns(profile, columns);
  unfold(profile, columns);
  return in.error;
}

}  // namespace kinora::light
