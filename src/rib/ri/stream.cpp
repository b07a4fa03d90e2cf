#include "rib/ri/stream.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rib/words.h"

namespace kinora::rib::ri {

namespace {

constexpr size_t kFlush = 1 << 16, kMostLevels = 64;

bool isText(const Declaration& d) {
  return d.isReference || (!scene::isFloatBased(d.type) && d.type != scene::ValueType::Int);
}

// The longest diagonal of a box under a transform.
double sizeUnder(const scene::Matrix& m, const float bound[6]) {
  double most = 0;
  for (int i = 0; i < 4; ++i) {
    const int j = 7 - i;
    const Imath::V3d a(bound[i & 1], bound[2 + (i >> 1 & 1)], bound[4 + (i >> 2)]);
    const Imath::V3d b(bound[j & 1], bound[2 + (j >> 1 & 1)], bound[4 + (j >> 2)]);
    most = std::max(most, (a * m - b * m).length());
  }
  return most;
}

}  // namespace

Stream& stream() {
  static Stream only;
  return only;
}

bool Stream::close() {
  end();
  print({});
  if (std::fflush(out_) != 0) hasFailed_ = true;
  return !hasFailed_;
}

void Stream::end() {
  if (isOpen_) text_ += '\n';
  isOpen_ = false;
  if (text_.size() > kFlush) print({});
}

// Writes what has gathered, and this.
void Stream::print(std::string_view text) {
  text_ += text;
  if (std::fwrite(text_.data(), 1, text_.size(), out_) != text_.size()) hasFailed_ = true;
  text_.clear();
}

Stream& Stream::request(const char* name) {
  end();
  text_ += name;
  isOpen_ = true;
  return *this;
}

template <class T>
void Stream::numberText(T v) {
  if constexpr (std::is_floating_point_v<T>)
    if (!std::isfinite(v)) {
      // RIB has no word for these; what reads it limits such numbers likewise
      text_ += std::isnan(v) ? "0" : v > 0 ? "1e38" : "-1e38";
      return;
    }
  appendNumber(v, text_);
  if (text_.size() > kFlush) print({});
}

void Stream::quoted(const char* text) { appendString(text ? text : "", text_); }

Stream& Stream::word(const char* text) {
  text_ += ' ';
  quoted(text);
  return *this;
}
Stream& Stream::number(double x) {
  text_ += ' ';
  numberText(float(x));
  return *this;
}
Stream& Stream::integer(long x) {
  text_ += ' ';
  numberText(x);
  return *this;
}
template <class T, class Put>
Stream& Stream::bracketed(const T* x, size_t n, const Put& put) {
  text_ += " [";
  for (size_t i = 0; i < n; ++i) {
    if (i) text_ += ' ';
    put(x[i]);
  }
  text_ += ']';
  return *this;
}
Stream& Stream::floats(const RtFloat* x, size_t n) {
  return bracketed(x, n, [&](RtFloat v) { numberText(v); });
}
Stream& Stream::integers(const RtInt* x, size_t n) {
  return bracketed(x, n, [&](RtInt v) { numberText(v); });
}
Stream& Stream::words(const RtToken* x, size_t n) {
  return bracketed(x, n, [&](const char* v) { quoted(v); });
}

void Stream::list(const Given& given, const PrimvarCounts& counts) {
  for (RtInt i = 0; i < given.n; ++i) {
    if (!given.tokens[i] || !given.values[i]) continue;
    const Declaration* d = declarations_.find(given.tokens[i]);
    if (!d) {
      std::fprintf(stderr, "kinora-procedural: '%s' is not declared; it is left out\n", given.tokens[i]);
      continue;
    }
    word(given.tokens[i]);
    const size_t values = counts.of(d->storage) * size_t(std::max(d->arrayLength, 1));
    if (isText(*d))
      words(static_cast<const RtToken*>(given.values[i]), values);
    else if (d->type == scene::ValueType::Int)
      integers(static_cast<const RtInt*>(given.values[i]), values);
    else
      floats(static_cast<const RtFloat*>(given.values[i]), values * size_t(scene::componentsOf(d->type)));
  }
}

bool Stream::declare(const std::string& name, const char* declaration) {
  return declaration && declarations_.declare(name, declaration);
}

void Stream::push(bool withAttributes) {
  State s = states_.back();
  s.uStep = steps_.uStep, s.vStep = steps_.vStep;
  s.withAttributes = withAttributes;
  states_.push_back(s);
}
void Stream::pop(bool withAttributes) {
  if (states_.size() < 2 || states_.back().withAttributes != withAttributes) return;  // the reader tells of it
  if (withAttributes) basisSteps(states_.back().uStep, states_.back().vStep);
  states_.pop_back();
}

Stream& Stream::handle(RtPointer x) { return word((name_ + std::to_string(reinterpret_cast<intptr_t>(x))).c_str()); }

void Stream::begin(std::string name, double detail, std::optional<std::span<const float, 6>> bound) {
  name_ = std::move(name);
  levels_ = {{detail, bound ? sizeUnder(scene::Matrix(), bound->data()) : 0}};
}

std::optional<double> Stream::enterProcedural(const RtBound bound) {
  if (levels_.size() >= kMostLevels) {
    std::fprintf(stderr, "kinora-procedural: procedurals are %zu deep within each other; the next is left out\n",
                 levels_.size());
    return std::nullopt;
  }
  const Level& outer = levels_.back();
  const double size = sizeUnder(transform(), bound), share = outer.size > 0 ? size / outer.size : 1;
  const double detail = outer.detail * share * share;
  if (!std::isfinite(detail)) return std::nullopt;
  levels_.push_back({detail, size});
  return detail;
}
void Stream::leaveProcedural() { levels_.pop_back(); }

}  // namespace kinora::rib::ri
