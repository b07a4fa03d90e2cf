#include "language/expression.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <stdexcept>

namespace kinora::oracle {

namespace {

using std::string_view;

double dotOf(const Numbers& a, const Numbers& b) { return a.at(0) * b.at(0) + a.at(1) * b.at(1) + a.at(2) * b.at(2); }

template <class F>
Numbers each(const Numbers& a, const Numbers& b, F&& f) {
  if (a.size() != b.size() && a.size() != 1 && b.size() != 1) throw std::runtime_error("sizes differ");
  Numbers r(std::max(a.size(), b.size()));
  for (size_t i = 0; i < r.size(); ++i) r[i] = f(a[a.size() == 1 ? 0 : i], b[b.size() == 1 ? 0 : i]);
  return r;
}

const std::map<string_view, double (*)(double)> kOne = {
    {"sin", std::sin},     {"cos", std::cos},     {"tan", std::tan},   {"asin", std::asin},   {"acos", std::acos},
    {"atan", std::atan},   {"sinh", std::sinh},   {"cosh", std::cosh}, {"tanh", std::tanh},   {"exp", std::exp},
    {"exp2", std::exp2},   {"expm1", std::expm1}, {"log", std::log},   {"log2", std::log2},   {"log10", std::log10},
    {"logb", std::logb},   {"sqrt", std::sqrt},   {"cbrt", std::cbrt}, {"floor", std::floor}, {"ceil", std::ceil},
    {"round", std::round}, {"trunc", std::trunc}, {"abs", std::fabs},  {"erf", std::erf},     {"erfc", std::erfc}};
const std::map<string_view, double (*)(double, double)> kTwo = {
    {"pow", std::pow},
    {"atan2", std::atan2},
    {"fmod", std::fmod},
    {"min", [](double a, double b) { return a <= b ? a : b; }},
    {"max", [](double a, double b) { return a > b ? a : b; }},
    {"hypot", [](double a, double b) { return std::hypot(a, b); }}};

class Reader {
 public:
  Reader(string_view text, const Variables& variables) : text_(text), variables_(variables) {}
  Numbers all() {
    Numbers r = choice();
    skip();
    if (at_ != text_.size()) fail("'" + std::string(text_.substr(at_)) + "' is left");
    return r;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw std::runtime_error(std::string(text_) + ": " + why); }
  void skip() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  bool take(string_view s) {
    skip();
    if (text_.substr(at_, s.size()) != s) return false;
    at_ += s.size();
    return true;
  }
  void need(string_view s) {
    if (!take(s)) fail("no '" + std::string(s) + "' at '" + std::string(text_.substr(at_)) + "'");
  }
  static bool isTrue(const Numbers& a) { return a.at(0) != 0; }

  Numbers choice() {
    Numbers c = binary(0);
    if (!take("?")) return c;
    Numbers a = choice();
    need(":");
    Numbers b = choice();
    return isTrue(c) ? a : b;
  }
  Numbers binary(size_t level) {
    struct Op {
      string_view text;
      double (*f)(double, double);
    };
    static const std::vector<std::vector<Op>> kLevels = {
        {{"||", [](double a, double b) { return double(a != 0 || b != 0); }}},
        {{"&&", [](double a, double b) { return double(a != 0 && b != 0); }}},
        {{"==", [](double a, double b) { return double(a == b); }},
         {"!=", [](double a, double b) { return double(a != b); }}},
        {{"<=", [](double a, double b) { return double(a <= b); }},
         {">=", [](double a, double b) { return double(a >= b); }},
         {"<", [](double a, double b) { return double(a < b); }},
         {">", [](double a, double b) { return double(a > b); }}},
        {{"+", [](double a, double b) { return a + b; }}, {"-", [](double a, double b) { return a - b; }}},
        {{"*", [](double a, double b) { return a * b; }},
         {"/", [](double a, double b) { return a / b; }},
         {"%", [](double a, double b) { return std::fmod(a, b); }}}};
    if (level == kLevels.size()) return unary();
    Numbers a = binary(level + 1);
    for (bool isMore = true; isMore;) {
      isMore = false;
      for (const Op& op : kLevels[level])
        if (take(op.text)) {
          a = each(a, binary(level + 1), op.f);
          isMore = true;
          break;
        }
    }
    return a;
  }
  Numbers unary() {
    if (take("-")) {
      Numbers a = unary();
      for (double& x : a) x = -x;
      return a;
    }
    if (take("!")) return {double(!isTrue(unary()))};
    Numbers a = primary();
    for (;;) {
      if (take("[")) {
        const Numbers i = choice();
        need("]");
        a = {a.at(size_t(i.at(0)))};
      } else if (take(".")) {
        const size_t k = std::string("xyzrgb").find(text_[at_++]);
        a = {a.at(k % 3)};
      } else {
        return a;
      }
    }
  }
  Numbers list(string_view end) {
    Numbers r;
    do {
      const Numbers a = choice();
      r.insert(r.end(), a.begin(), a.end());
    } while (take(","));
    need(end);
    return r;
  }
  Numbers primary() {
    if (take("(")) return list(")");
    if (take("{")) return list("}");
    skip();
    if (at_ < text_.size() && (std::isdigit(text_[at_]) || text_[at_] == '.')) {
      const std::string rest(text_.substr(at_));
      char* end = nullptr;
      const double d = std::strtod(rest.c_str(), &end);
      at_ += size_t(end - rest.c_str());
      return {d};
    }
    const size_t begin = at_;
    while (at_ < text_.size() && (std::isalnum(text_[at_]) || text_[at_] == '_')) ++at_;
    const string_view name = text_.substr(begin, at_ - begin);
    if (name.empty()) fail("nothing at '" + std::string(text_.substr(at_)) + "'");
    if (!take("(")) {
      if (name == "pi") return {M_PI};
      if (name == "inf") return {INFINITY};
      if (name == "nan") return {NAN};
      const auto v = variables_.find(name);
      if (v == variables_.end()) fail("what is '" + std::string(name) + "'?");
      return v->second;
    }
    std::vector<Numbers> a;
    do a.push_back(choice());
    while (take(","));
    need(")");
    if (const auto one = kOne.find(name); one != kOne.end() && a.size() == 1) {
      for (double& x : a[0]) x = one->second(x);
      return a[0];
    }
    if (const auto two = kTwo.find(name); two != kTwo.end() && a.size() == 2) return each(a[0], a[1], two->second);
    if (name == "clamp") return each(each(a.at(0), a.at(2), kTwo.at("min")), a.at(1), kTwo.at("max"));
    if (name == "dot") return {dotOf(a.at(0), a.at(1))};
    if (name == "length") return {std::sqrt(dotOf(a.at(0), a[0]))};
    if (name == "float") {  // as a float holds it
      for (double& x : a[0]) x = double(float(x));
      return a[0];
    }
    if (name == "normalize") {
      const double l = std::sqrt(dotOf(a.at(0), a[0]));
      return each(a[0], {l}, [](double x, double y) { return y > 0 ? x / y : 0.0; });
    }
    if (name == "cross") {
      const Numbers &p = a.at(0), &q = a.at(1);
      return {p.at(1) * q.at(2) - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]};
    }
    fail("no function '" + std::string(name) + "'");
  }

  string_view text_;
  const Variables& variables_;
  size_t at_ = 0;
};

}  // namespace

Numbers evaluate(string_view formula, const Variables& variables) { return Reader(formula, variables).all(); }

}  // namespace kinora::oracle
