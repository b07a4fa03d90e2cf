#include "rib/condition.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <regex>
#include <vector>

namespace kinora::rib {

namespace {

bool isNameChar(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':';
}

std::optional<double> asNumber(std::string_view s) {
  while (!s.empty() && s.front() == ' ') s.remove_prefix(1);
  while (!s.empty() && s.back() == ' ') s.remove_suffix(1);
  if (!s.empty() && s.front() == '+') s.remove_prefix(1);
  double v = 0;
  const auto r = std::from_chars(s.data(), s.data() + s.size(), v);
  if (r.ec != std::errc() || r.ptr != s.data() + s.size()) return std::nullopt;
  return v;
}

// Values of a scene are floats, literals are not: .1 is the float next to it. Whole numbers (identifiers, frames) are
// compared exactly.
int compareNumbers(double a, double b) {
  if (std::floor(a) != a || std::floor(b) != b) a = float(a), b = float(b);
  return a < b ? -1 : a > b;
}

// The numbers of a colour, point or matrix, between blanks or commas; none where something else is among them.
std::vector<double> asNumbers(std::string_view s) {
  constexpr std::string_view kBetween = " ,\t\r\n";
  std::vector<double> r;
  for (size_t at = s.find_first_not_of(kBetween); at != std::string_view::npos;) {
    const size_t end = std::min(s.find_first_of(kBetween, at), s.size());
    const auto n = asNumber(s.substr(at, end - at));
    if (!n) return {};
    r.push_back(*n);
    at = s.find_first_not_of(kBetween, end);
  }
  return r;
}

// Everything is text; a text that reads as a number is one where numbers are wanted. What && and || decide without their
// right side is decided, whatever names that has. Precedence from low to high:
// || && (== != =~) (< <= > >=) (+ -) (* /) ^ unary.
class Parser {
 public:
  Parser(std::string_view text, const Lookup& lookup) : text_(text), lookup_(lookup) {}

  bool run(std::string& problem) {
    const std::string v = either();
    space();
    if (problem_.empty() && at_ < text_.size())
      fail("'" + std::string(text_.substr(at_, 20)) + "' is not understood");
    problem = problem_;
    return problem_.empty() && truth(v);
  }

 private:
  static constexpr int kMostDepth = 200;

  void fail(std::string what) {
    if (problem_.empty()) problem_ = std::move(what);
    at_ = text_.size();
  }
  // Of what cannot be told from the syntax: nothing where the side does not count.
  void failToEvaluate(std::string what) {
    if (!unused_) fail(std::move(what));
  }
  void space() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
      ++at_;
  }
  bool take(std::string_view op) {
    space();
    if (text_.substr(at_, op.size()) != op) return false;
    at_ += op.size();
    return true;
  }
  static bool truth(const std::string& v) {
    const auto n = asNumber(v);
    return n ? *n != 0 : !v.empty() && v != "false";
  }
  static std::string text(double v) {
    char buffer[32];
    const auto r = std::to_chars(buffer, buffer + sizeof buffer, v);
    return std::string(buffer, r.ptr);
  }
  static std::string text(bool b) { return b ? "1" : "0"; }
  static int compare(const std::string& a, const std::string& b) {
    const std::vector<double> x = asNumbers(a), y = asNumbers(b);
    if (x.empty() || x.size() != y.size()) return a < b ? -1 : a > b;
    for (size_t i = 0; i < x.size(); ++i)
      if (const int c = compareNumbers(x[i], y[i])) return c;
    return 0;
  }
  double numeric(const std::string& v) {
    const auto n = asNumber(v);
    if (!n) failToEvaluate("'" + v + "' is not a number");
    return n.value_or(0);
  }
  bool matches(const std::string& subject, const std::string& pattern) {
    if (pattern.size() > 256 || subject.size() > 4096) return fail("a pattern is too long"), false;
    try {
      // matching in polynomial time: a pattern from a file must not be able to stop the reader
      return std::regex_search(subject,
                               std::regex(pattern, std::regex::ECMAScript | std::regex_constants::__polynomial));
    } catch (const std::regex_error&) {
      fail("'" + pattern + "' is not a pattern");
      return false;
    }
  }

  std::string either() {
    std::string v = both();
    while (take("||")) {
      const bool left = truth(v);
      unused_ += left;
      const bool right = truth(both());
      unused_ -= left;
      v = text(left || right);
    }
    return v;
  }
  std::string both() {
    std::string v = equality();
    while (take("&&")) {
      const bool left = truth(v);
      unused_ += !left;
      const bool right = truth(equality());
      unused_ -= !left;
      v = text(left && right);
    }
    return v;
  }
  std::string equality() {
    std::string v = order();
    for (;;) {
      if (take("=="))
        v = text(compare(v, order()) == 0);
      else if (take("!="))
        v = text(compare(v, order()) != 0);
      else if (take("=~"))
        v = text(matches(v, order()));
      else
        return v;
    }
  }
  std::string order() {
    std::string v = sum();
    for (;;) {
      if (take("<="))
        v = text(compare(v, sum()) <= 0);
      else if (take(">="))
        v = text(compare(v, sum()) >= 0);
      else if (take("<"))
        v = text(compare(v, sum()) < 0);
      else if (take(">"))
        v = text(compare(v, sum()) > 0);
      else
        return v;
    }
  }
  std::string sum() {
    std::string v = product();
    for (;;) {
      if (take("+"))
        v = text(numeric(v) + numeric(product()));
      else if (take("-"))
        v = text(numeric(v) - numeric(product()));
      else
        return v;
    }
  }
  std::string product() {
    std::string v = power();
    for (;;) {
      if (take("*"))
        v = text(numeric(v) * numeric(power()));
      else if (take("/")) {
        const double by = numeric(power());
        if (by == 0)
          failToEvaluate("division by zero");
        else
          v = text(numeric(v) / by);
      } else
        return v;
    }
  }
  std::string power() {
    std::string v = unary();
    if (!take("^")) return v;
    if (++depth_ > kMostDepth) return fail("it is nested too deeply"), std::string();
    v = text(std::pow(numeric(v), numeric(power())));
    --depth_;
    return v;
  }
  std::string unary() {
    if (++depth_ > kMostDepth) return fail("it is nested too deeply"), std::string();
    std::string v;
    space();
    if (text_.substr(at_, 2) != "!=" && take("!"))
      v = text(!truth(unary()));
    else if (take("-"))
      v = text(-numeric(unary()));
    else
      v = primary();
    --depth_;
    return v;
  }
  std::string name(bool dots = false) {
    space();
    const size_t from = at_;
    while (at_ < text_.size() && (isNameChar(text_[at_]) || (dots && text_[at_] == '.'))) ++at_;
    return std::string(text_.substr(from, at_ - from));
  }
  std::string primary() {
    space();
    if (at_ >= text_.size()) return fail("it ends too early"), std::string();
    if (take("(")) {
      std::string v = either();
      if (!take(")")) fail("a ')' is missing");
      return v;
    }
    const char c = text_[at_];
    if (c == '\'' || c == '"') {
      const size_t close = text_.find(c, at_ + 1);
      if (close == std::string_view::npos) return fail("a quote is not closed"), std::string();
      const std::string_view inside = text_.substr(at_ + 1, close - at_ - 1);
      at_ = close + 1;
      return substitute(inside, '$', true, lookup_);
    }
    if (c == '[') {  // a colour or point: compared number by number
      const size_t close = text_.find(']', at_);
      if (close == std::string_view::npos) return fail("a ']' is missing"), std::string();
      std::string v(text_.substr(at_ + 1, close - at_ - 1));
      at_ = close + 1;
      return v;
    }
    if (c == '$') {
      ++at_;
      const bool braces = at_ < text_.size() && text_[at_] == '{';
      if (braces) ++at_;
      const std::string n = name();
      if (braces && !take("}")) return fail("a '}' is missing"), std::string();
      const auto v = lookup_(n);
      if (!v) failToEvaluate("'" + n + "' is not defined");
      return v.value_or("");
    }
    std::string w = name(true);  // a number, or a bare word
    // "1e-3": the sign of an exponent
    if (at_ < text_.size() && (text_[at_] == '-' || text_[at_] == '+') && w.size() > 1 && asNumber(w + "0") &&
        (w.back() == 'e' || w.back() == 'E') && at_ + 1 < text_.size() && text_[at_ + 1] >= '0' &&
        text_[at_ + 1] <= '9') {
      w += text_[at_++];
      w += name();
    }
    if (w.empty()) return fail("'" + std::string(text_.substr(at_, 20)) + "' is not understood"), std::string();
    if (w == "defined" && take("(")) {
      take("$");
      std::string n = name();
      if (n.empty() && take("'")) {
        n = name();
        take("'");
      }
      if (!take(")")) fail("a ')' is missing");
      return text(lookup_(n).has_value());
    }
    if (w == "concat" && take("(")) {
      std::string v;
      do v += either();
      while (take(",") && v.size() < 65536);
      if (!take(")")) fail("a ')' is missing");
      return v;
    }
    return w;
  }

  std::string_view text_;
  const Lookup& lookup_;
  size_t at_ = 0;
  int depth_ = 0, unused_ = 0;  // unused_: how many sides around here do not count
  std::string problem_;
};

}  // namespace

std::string plainText(float v) {
  char buffer[64];
  const float size = std::abs(v);
  const bool isUsual = v == 0 || (size >= 1e-5f && size < 1e9f);
  const auto r = isUsual ? std::to_chars(buffer, buffer + sizeof buffer, v, std::chars_format::fixed)
                         : std::to_chars(buffer, buffer + sizeof buffer, v);
  return std::string(buffer, r.ptr);
}

std::string plainText(int v) { return std::to_string(v); }

std::string plainText(const scene::Parameter& p) {
  if (!p.strings.empty()) return p.strings[0];
  std::string s;
  for (size_t i = 0; i < p.size() && i < 16; ++i)
    s += (i ? " " : "") + (p.ints.empty() ? plainText(p.floats[i]) : plainText(p.ints[i]));
  return s;
}

bool evaluateCondition(std::string_view expression, const Lookup& lookup, std::string& problem) {
  return Parser(expression, lookup).run(problem);
}

std::string substitute(std::string_view text, char marker, bool bare, const Lookup& lookup) {
  std::string out;
  size_t at = 0;
  while (at < text.size()) {
    const size_t found = text.find(marker, at);
    out += text.substr(at, found == std::string_view::npos ? found : found - at);
    if (found == std::string_view::npos) break;
    size_t from = found + 1, to = from, after = from;
    if (from < text.size() && text[from] == '{') {
      to = text.find('}', ++from);
      if (to == std::string_view::npos)
        to = from;
      else
        after = to + 1;
    } else if (bare) {
      while (to < text.size() && isNameChar(text[to])) ++to;
      while (to > from && text[to - 1] == ':') --to;
      after = to;
    }
    const auto value = to > from ? lookup(text.substr(from, to - from)) : std::nullopt;
    if (value) {
      out += *value;
      at = after;
    } else {
      out += marker;
      at = found + 1;
    }
  }
  return out;
}

}  // namespace kinora::rib
