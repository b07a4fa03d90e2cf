// Work that goes point by point, the same for every width: array elements by an index that varies, strings, messages,
// and what the renderer answers.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "language/program/program.h"
#include "language/vm/executable.h"
#include "language/vm/kernel.h"
#include "language/vm/strings.h"

namespace kinora::language {

namespace {

int32_t intAt(const float* p, uint32_t i) {
  int32_t value;
  std::memcpy(&value, p + i, 4);
  return value;
}
void setInt(float* p, uint32_t i, int32_t value) { std::memcpy(p + i, &value, 4); }

// components, result, array, array varies, index, index varies
void arrayRead(const Frame& f, const uint32_t* w) {
  const uint32_t n = w[0];
  const bool varies = w[3];
  const float* index = f.cells[w[4]];
  if (!w[5]) {
    const uint32_t at = uint32_t(intAt(index, 0)) * n;
    for (uint32_t c = 0; c < n; ++c) {
      const float* from = f.cells[w[2] + at + c];
      float* to = f.cells[w[1] + c];
      if (varies) std::memcpy(to, from, size_t(f.points) * 4);
      else std::fill(to, to + f.points, from[0]);
    }
    return;
  }
  for (uint32_t c = 0; c < n; ++c) {
    float* to = f.cells[w[1] + c];
    for (uint32_t i = 0; i < f.points; ++i) to[i] = f.cells[w[2] + uint32_t(intAt(index, i)) * n + c][varies ? i : 0];
  }
}

// components of one element, array, value, its step, value varies, index, index varies, has a mask, mask
void arrayWrite(const Frame& f, const uint32_t* w) {
  const uint32_t n = w[0];
  const float* index = f.cells[w[5]];
  const int32_t* mask = w[7] ? reinterpret_cast<const int32_t*>(f.cells[w[8]]) : nullptr;
  for (uint32_t c = 0; c < n; ++c) {
    const float* value = f.cells[w[2] + c * w[3]];
    for (uint32_t i = 0; i < f.points; ++i) {
      if (mask && intAt(f.cells[w[8]], i) == 0) continue;
      f.cells[w[1] + uint32_t(intAt(index, w[6] ? i : 0)) * n + c][i] = value[w[4] ? i : 0];
    }
  }
}

std::string placeOf(const Executable& e, const Site& site) {
  return site.position + " (group " + e.group() + ", layer " + std::to_string(site.layer) + " " + SiteAccess::layer(e, site.layer) + ", shader " + SiteAccess::shader(e, site.layer) + ")";
}

// A message of a site, once a run: that of the first point that has cause.
void tellOnce(const Frame& f, uint32_t number, uint32_t point, const std::string& text) {
  RunState& run = *f.run;
  if (run.toldOnce[number]) return;
  run.toldOnce[number] = 1;
  run.say(f.first + point, MessageKind::Error, text);
}

// site, result, index, varies, length, has a mask, mask
void checkIndex(const Frame& f, const uint32_t* w) {
  float* to = f.cells[w[1]];
  const float* from = f.cells[w[2]];
  const int32_t length = int32_t(w[4]);
  for (uint32_t i = 0; i < f.points; ++i) {
    const int32_t index = intAt(from, w[3] ? i : 0), kept = std::clamp(index, 0, length - 1);
    setInt(to, i, kept);
    if (kept == index || (w[5] && intAt(f.cells[w[6]], i) == 0)) continue;
    const Executable& e = *f.run->program;
    if (f.run->toldOnce[w[0]] || !SiteAccess::rangeCheck(e)) continue;
    const Site& site = SiteAccess::site(e, w[0]);
    tellOnce(f, w[0], i, "Index [" + std::to_string(index) + "] out of range " + site.name + "[0.." + std::to_string(length - 1) + "]: " + placeOf(e, site));
  }
}

// site, count, any, limit
void loopLimit(const Frame& f, const uint32_t* w) {
  const uint32_t count = uint32_t(intAt(f.cells[w[1]], 0)) + 1;
  setInt(f.cells[w[1]], 0, int32_t(count));
  setInt(f.cells[w[2]], 0, count < w[3]);
  if (count < w[3]) return;
  f.run->stopped = true;
  const Executable& e = *f.run->program;
  tellOnce(f, w[0], 0, "a loop was stopped after " + std::to_string(w[3]) + " turns: " + placeOf(e, SiteAccess::site(e, w[0])));
}

// ---- operations with a list of arguments: see CodeGenerator::scalar ----
struct Call {
  const Frame& f;
  const uint32_t* w;
  uint32_t count() const { return w[0]; }
  uint32_t siteNumber() const { return w[1]; }
  const Site& site() const { return SiteAccess::site(*f.run->program, w[1]); }
  uint32_t extra() const { return w[2]; }
  bool isLive(uint32_t i) const { return !w[3] || intAt(f.cells[w[4]], i) != 0; }
  const uint32_t* argument(uint32_t k) const { return w + 5 + 4 * k; }
  Base base(uint32_t k) const { return Base(argument(k)[1] & 255); }
  bool varies(uint32_t k) const { return argument(k)[1] >> 8 & 1; }
  bool isArray(uint32_t k) const { return argument(k)[1] >> 10 & 1; }
  uint32_t cells(uint32_t k) const { return argument(k)[2]; }
  float number(uint32_t k, uint32_t i, uint32_t c = 0) const { return f.cells[argument(k)[0] + c][varies(k) ? i : 0]; }
  int32_t integer(uint32_t k, uint32_t i, uint32_t c = 0) const { return intAt(f.cells[argument(k)[0] + c], varies(k) ? i : 0); }
  const std::string& text(uint32_t k, uint32_t i, uint32_t c = 0) const { return stringOf(integer(k, i, c)); }
  void set(uint32_t k, uint32_t i, float value, uint32_t c = 0) const { f.cells[argument(k)[0] + c][varies(k) ? i : 0] = value; }
  void set(uint32_t k, uint32_t i, int32_t value, uint32_t c = 0) const { setInt(f.cells[argument(k)[0] + c], varies(k) ? i : 0, value); }
  Batch batch() const { return {f.points, f.first, w[3] ? reinterpret_cast<const int32_t*>(f.cells[w[4]]) : nullptr}; }
  Span span(uint32_t k) const {
    Span s;
    s.cells = f.cells + argument(k)[0];
    s.components = cells(k);
    s.base = uint8_t(base(k));
    s.varies = varies(k);
    return s;
  }
  Span derivs(uint32_t k, uint32_t axis) const {  // no components: none
    Span s = span(k);
    if (argument(k)[1] >> 9 & 1) s.cells = f.cells + argument(k)[3] + (axis == 1 ? 0 : cells(k));
    else s.components = 0;
    return s;
  }
};

std::string formatted(const Call& call, uint32_t first, uint32_t point) {
  const std::string& format = call.text(first, point);
  std::string out;
  uint32_t next = first + 1;
  for (size_t at = 0; at < format.size(); ++at) {
    if (format[at] != '%') {
      out += format[at];
      continue;
    }
    if (at + 1 < format.size() && format[at + 1] == '%') {
      out += '%';
      ++at;
      continue;
    }
    size_t end = at + 1;
    while (end < format.size() && !std::strchr("cdefgimnopsuvxX", format[end])) ++end;
    if (end >= format.size() || next >= call.count()) {
      out += format.substr(at);
      break;
    }
    std::string flags = format.substr(at, end - at);
    char letter = format[end];
    at = end;
    const uint32_t k = next++;
    for (uint32_t c = 0; c < call.cells(k); ++c) {
      char buffer[512];
      if (c) out += ' ';
      if (call.base(k) == Base::String) {
        out += call.text(k, point, c);
      } else if (call.base(k) == Base::Int) {
        if (letter != 'x' && letter != 'X' && letter != 'o' && letter != 'u') letter = 'd';
        std::snprintf(buffer, sizeof buffer, (flags + letter).c_str(), call.integer(k, point, c));
        out += buffer;
      } else {
        if (letter != 'e' && letter != 'g') letter = 'f';
        std::snprintf(buffer, sizeof buffer, (flags + letter).c_str(), double(call.number(k, point, c)));
        out += buffer;
      }
    }
  }
  return out;
}

void printf(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  const MessageKind kind = MessageKind(call.extra());
  const uint32_t first = kind == MessageKind::File ? 1 : 0;
  const Executable& e = *f.run->program;
  std::string prefix;
  if (kind == MessageKind::Error) prefix = "Shader error [" + SiteAccess::shader(e, call.site().layer) + "]: ";
  if (kind == MessageKind::Warning) prefix = "Shader warning [" + SiteAccess::shader(e, call.site().layer) + "]: ";
  for (uint32_t i = 0; i < f.points; ++i)
    if (call.isLive(i)) f.run->say(f.first + i, kind, prefix + formatted(call, first, i), first ? call.text(0, i) : std::string());
}

template <class F>
void eachLive(const Call& call, F&& work) {
  const bool once = !call.varies(0);
  for (uint32_t i = 0; i < (once ? 1u : call.f.points); ++i)
    if (once || call.isLive(i)) work(i);
}

void format(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, internString(formatted(call, 1, i))); });
}
void concat(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    std::string all;
    for (uint32_t k = 1; k < call.count(); ++k) all += call.text(k, i);
    call.set(0, i, internString(all));
  });
}
void stringLength(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(call.text(1, i).size())); });
}
void getChar(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    const std::string& s = call.text(1, i);
    const int32_t at = call.integer(2, i);
    call.set(0, i, at >= 0 && size_t(at) < s.size() ? int32_t(uint8_t(s[size_t(at)])) : 0);
  });
}
void startsWith(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(call.text(1, i).starts_with(call.text(2, i)))); });
}
void endsWith(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(call.text(1, i).ends_with(call.text(2, i)))); });
}
void substr(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    const std::string& s = call.text(1, i);
    const int64_t size = int64_t(s.size());
    int64_t start = call.integer(2, i);
    if (start < 0) start += size;
    start = std::clamp<int64_t>(start, 0, size);
    const int64_t length = std::clamp<int64_t>(call.integer(3, i), 0, size - start);
    call.set(0, i, internString(std::string_view(s).substr(size_t(start), size_t(length))));
  });
}
void stringToInt(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(std::clamp(std::strtoll(call.text(1, i).c_str(), nullptr, 10), -2147483648ll, 2147483647ll))); });
}
void stringToFloat(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, std::strtof(call.text(1, i).c_str(), nullptr)); });
}

void rayType(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  for (uint32_t i = 0; i < f.points; ++i) call.set(0, i, 0);
  if (f.run->services->rayType) f.run->services->rayType(f.run->services->self, call.batch(), call.span(1), call.span(0));
}
void backfacing(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  for (uint32_t i = 0; i < f.points; ++i) call.set(0, i, 0);
  if (f.run->services->backfacing) f.run->services->backfacing(f.run->services->self, call.batch(), call.span(0));
}
void surfaceArea(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  for (uint32_t i = 0; i < f.points; ++i) call.set(0, i, 0.f);
  if (f.run->services->surfaceArea) f.run->services->surfaceArea(f.run->services->self, call.batch(), call.span(0));
}

void refuse(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  for (uint32_t i = 0; i < f.points; ++i) {
    if (!call.isLive(i)) continue;
    tellOnce(f, call.siteNumber(), i, call.site().name + " is not supported: " + placeOf(*f.run->program, call.site()));
    break;
  }
}
void unanswered(const Frame&, const uint32_t*) {}

constexpr KernelFunction kScalar[] = {
    &arrayRead, &arrayWrite, &checkIndex, &printf, &format, &concat, &stringLength, &getChar,
    &startsWith, &endsWith, &substr, &stringToInt, &stringToFloat, &refuse, &refuse, &refuse, &unanswered,
    &unanswered, &rayType, &backfacing, &surfaceArea, &unanswered, &unanswered, &unanswered,
    &unanswered, &refuse, &refuse, &refuse, &loopLimit, &refuse};
static_assert(sizeof kScalar / sizeof *kScalar == size_t(Scalar::Count));

}  // namespace

const KernelFunction* scalarKernels() { return kScalar; }

}  // namespace kinora::language
