#include <cfloat>
#include <climits>
#include <cmath>

#include "rib/interpreter.h"

namespace kinora::rib {

using scene::Parameter;
using scene::ParameterList;
using scene::StorageClass;
using scene::ValueType;

namespace {

// Small arrays are copied out of the reader's buffers, large ones leave with them.
constexpr size_t kCopied = 1 << 14;

template <class T>
std::vector<T> takeValues(std::vector<T>& from) {
  if (from.size() <= kCopied) return from;
  std::vector<T> v = std::move(from);
  from.clear();
  if (v.capacity() > v.size() + v.size() / 8) v.shrink_to_fit();
  return v;
}

// Fits for any double: too large and too small become the ends of the range, nan 0.
int toInt(double v) {
  if (!(v == v)) return 0;
  return v >= INT_MAX ? INT_MAX : v <= INT_MIN ? INT_MIN : int(v);
}

}  // namespace

bool Interpreter::Cursor::numbers(size_t count, double* out) {
  size_t have = 0, next = at;
  while (have < count) {
    if (next >= request.count) return false;
    const Argument& a = request.args[next++];
    if (a.kind != Argument::Kind::Numbers || a.exact.empty()) return false;
    const size_t n = std::min(a.exact.size(), count - have);
    std::copy_n(a.exact.begin(), n, out + have);
    have += n;
  }
  at = next;
  return true;
}

bool Interpreter::Cursor::string(std::string& v) {
  if (at >= request.count || request.args[at].size() != 1) return false;
  const Argument& a = request.args[at];
  if (a.kind == Argument::Kind::Strings) {
    v = a.strings[0];
  } else {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.9g", a.exact[0]);
    v = buffer;
  }
  ++at;
  return true;
}

Argument* Interpreter::Cursor::array(Argument::Kind kind) {
  if (at >= request.count) return nullptr;
  Argument& a = request.args[at];
  if (a.kind != kind && a.size() > 0) return nullptr;  // [] is an array of either kind
  ++at;
  return &a;
}

bool Interpreter::Cursor::integers(std::vector<int>& v) {
  Argument* a = array(Argument::Kind::Numbers);
  if (!a) return false;
  if (a->isInteger) {
    v = takeValues(a->ints);
    return true;
  }
  v.clear();
  v.reserve(a->floats.size());
  for (float f : a->floats) {
    if (f != std::floor(f)) return false;  // nan and infinity too: an index must be a whole number
    v.push_back(toInt(f));
  }
  return true;
}

bool Interpreter::Cursor::floats(std::vector<float>& v) {
  Argument* a = array(Argument::Kind::Numbers);
  if (!a) return false;
  if (a->isInteger) a->becomeFloats();
  v = takeValues(a->floats);
  return true;
}

bool Interpreter::Cursor::strings(std::vector<std::string>& v) {
  Argument* a = array(Argument::Kind::Strings);
  if (!a) return false;
  v = a->strings;
  return true;
}

void Interpreter::badArguments(const Request& r, const std::string& wanted) {
  report(Severity::Error, "RIB-ARGUMENTS", r.pos, r.name + " needs " + wanted, "the request is ignored");
}

bool Interpreter::numbers(Cursor& c, size_t count, double* out, const char* wanted) {
  if (!c.numbers(count, out)) {
    badArguments(c.request, wanted);
    return false;
  }
  for (size_t i = 0; i < count; ++i) {
    if (std::isnan(out[i])) {
      report(Severity::Error, "RIB-NUMBER", c.request.pos, "a number of " + c.request.name + " is not a number",
             "the request is ignored");
      return false;
    }
    if (std::abs(out[i]) > FLT_MAX) {
      report(Severity::Error, "RIB-NUMBER", c.request.pos, "a number of " + c.request.name + " is too large",
             "the largest float, 3.4e38, is used");
      out[i] = std::copysign(double(FLT_MAX), out[i]);
    }
  }
  return true;
}

// The type of a name that nobody declared, from how its value is written. For options and attributes this is the rule
// (their bare names are older than inline declarations); elsewhere it is a repair.
std::optional<Declaration> Interpreter::guess(const Request& r, const std::string& token, const Argument& a,
                                              Use use) {
  if (use == Use::Primitive || token.find(' ') != std::string::npos || token.empty()) {
    report(Severity::Error, token.find(' ') == std::string::npos ? "RIB-UNDECLARED" : "RIB-DECLARATION",
           {r.pos.file, a.line},
           token.find(' ') == std::string::npos
               ? "nothing declares the parameter \"" + token + "\" of " + r.name
               : "\"" + token.substr(0, 60) + "\" in " + r.name + " is not a declaration",
           "the parameter is ignored", "write its type before its name, as in \"uniform float x\"");
    return std::nullopt;
  }
  Declaration d;
  d.name = token;
  const size_t n = a.size();
  if (a.kind == Argument::Kind::Strings)
    d.type = ValueType::String;
  else if (a.isInteger && n != 3 && n != 16)
    d.type = ValueType::Int;
  else if (n == 3 && (use == Use::Node || use == Use::Classic))
    d.type = ValueType::Color;
  else if (n == 16)
    d.type = ValueType::Matrix;
  if (d.type != ValueType::Color && d.type != ValueType::Matrix && n > 1) {
    d.isArray = true;
    d.arrayLength = int(std::min<size_t>(n, INT_MAX));
  }
  if (use == Use::Node)
    report(Severity::Warning, "RIB-UNDECLARED", {r.pos.file, a.line},
           "nothing declares the parameter \"" + token + "\" of " + r.name,
           std::string("it is read as ") + nameOf(d.type), "write its type before its name, as in \"float x\"");
  return d;
}

bool Interpreter::convert(Request& r, Argument& a, const Declaration& d, Parameter& p, Use use) {
  const auto drop = [&](const char* code, std::string what, std::string advice = {}) {
    report(Severity::Error, code, p.pos, "\"" + d.name + "\" of " + r.name + " " + what, "the parameter is ignored",
           std::move(advice));
    return false;
  };
  const bool isAnyLength = d.arrayLength == 0;
  if (isAnyLength) p.arrayLength = 1;
  const bool wantsStrings = d.isReference || d.type == ValueType::String || d.type >= ValueType::Bxdf;
  const bool isStrings = a.kind == Argument::Kind::Strings;
  if (a.size() == 0) {
    if (r.name == "Volume") return true;  // a field that the volume's own file holds is declared without values
    if (isAnyLength) return false;        // the empty array of exporters that list every parameter: its default holds
    return drop("RIB-ARRAY-LENGTH", "has no value");
  }
  if (wantsStrings != isStrings)
    return drop("RIB-TYPE",
                std::string("is declared ") + nameOf(d.type) + " and given " + (isStrings ? "strings" : "numbers"));
  const size_t components = wantsStrings ? 1 : size_t(componentsOf(d.type));
  const size_t element = components * size_t(p.arrayLength), given = a.size();
  const std::string length = d.isArray ? "[" + (isAnyLength ? "" : std::to_string(d.arrayLength)) + "]" : "";
  if (given % element != 0)
    return drop("RIB-ARRAY-LENGTH", "has " + std::to_string(given) + " values; " + nameOf(d.type) + length +
                                        " takes " + (use == Use::Primitive || isAnyLength ? "multiples of " : "") +
                                        std::to_string(element));
  if (isAnyLength) {
    if (use == Use::Primitive && p.storage != StorageClass::Constant)
      return drop(
          "RIB-DECLARATION",
          std::string("is declared ") + nameOf(d.type) + "[]: how many of its values are one element's is not said",
          std::string("write the number of each, as in \"") + nameOf(p.storage) + " " + nameOf(d.type) + "[2] " +
              d.name.substr(0, 60) + "\"");
    p.arrayLength = int(std::min<size_t>(given / components, INT_MAX));
  } else if (use != Use::Primitive && given > element) {
    p.isArray = true;
    p.arrayLength = int(std::min<size_t>(given / components, INT_MAX));
    report(Severity::Warning, "RIB-ARRAY-LENGTH", p.pos,
           "\"" + d.name + "\" of " + r.name + " has " + std::to_string(given) + " values and is declared for " +
               std::to_string(element),
           std::string("it is kept as an array of ") + std::to_string(p.arrayLength));
  }
  if (isStrings) {
    p.strings = a.strings;
    return true;
  }
  if (d.type == ValueType::Int) {
    if (a.isInteger) {
      p.ints = takeValues(a.ints);
      return true;
    }
    bool whole = true, fits = true;
    p.ints.edit().reserve(a.floats.size());
    for (float f : a.floats) {
      whole &= f == std::floor(f);
      fits &= std::abs(f) <= 0x1p31f;  // the least is -2^31; what is said beyond the most is 2^31 as a float
      p.ints.push_back(toInt(f));
    }
    for (size_t i = 0; i < a.exact.size(); ++i) fits &= a.exact[i] >= INT_MIN && a.exact[i] <= INT_MAX;
    if (!fits)
      report(Severity::Warning, "RIB-TYPE", p.pos,
             "\"" + d.name + "\" of " + r.name + " is an integer and given numbers beyond 2147483647, or nan",
             "the nearest integer, and 0, are used");
    else if (!whole)
      report(Severity::Warning, "RIB-TYPE", p.pos,
             "\"" + d.name + "\" of " + r.name + " is an integer and given fractions", "the fractions are cut off");
    return true;
  }
  if (a.isInteger) {
    p.floats.assign(a.ints.begin(), a.ints.end());
    return true;
  }
  if (a.notFinite) {
    const bool isPosition = use == Use::Primitive && (d.name == "P" || d.name == "Pw" || d.name == "Pz");
    if (isPosition) return drop("RIB-NUMBER", "holds nan or numbers beyond 3.4e38");
    for (float& f : a.floats) f = std::isnan(f) ? 0.f : std::min(FLT_MAX, std::max(-FLT_MAX, f));
    report(Severity::Error, "RIB-NUMBER", p.pos,
           "\"" + d.name + "\" of " + r.name + " holds nan or numbers beyond 3.4e38", "0 and 3.4e38 are used");
  }
  p.floats = takeValues(a.floats);
  return true;
}

ParameterList Interpreter::parameters(Request& r, size_t first, Use use) {
  ParameterList list;
  for (size_t i = first; i < r.count;) {
    const Argument& token = r.args[i];
    if (!token.isString()) {
      report(Severity::Error, "RIB-PARAMETER", {r.pos.file, token.line},
             "a value in the parameter list of " + r.name + " follows no name", "it is ignored");
      for (++i; i < r.count && !r.args[i].isString(); ++i) {
      }
      continue;
    }
    if (i + 1 == r.count) {
      report(Severity::Error, "RIB-PARAMETER", {r.pos.file, token.line},
             "\"" + token.strings[0].substr(0, 60) + "\" of " + r.name + " has no value", "it is ignored");
      break;
    }
    Argument& value = r.args[i + 1];
    size_t next = i + 2;
    // a row of bare numbers is one value that lacks its brackets
    if (value.kind == Argument::Kind::Numbers && !value.isArray)
      for (; next < r.count && r.args[next].kind == Argument::Kind::Numbers && !r.args[next].isArray; ++next) {
        const Argument& more = r.args[next];
        if (more.isInteger)
          value.addInteger(more.ints[0]);
        else
          value.addReal(more.exact[0]);
      }
    const std::string& name = token.strings[0];
    std::optional<Declaration> guessed;
    const Declaration* d = declarations_.find(name);
    if (!d && (guessed = guess(r, name, value, use))) d = &*guessed;
    if (d) {
      Parameter p;
      p.name = d->name;
      p.storage = d->storage;
      p.type = d->type;
      p.isReference = d->isReference;
      p.isArray = d->isArray;
      p.arrayLength = d->arrayLength;
      p.pos = {r.pos.file, token.line};
      if (!d->hasStorage)  // "normal N" has the class that N is known to have
        if (const Declaration* known = declarations_.find(d->name)) p.storage = known->storage;
      if (convert(r, value, *d, p, use)) list.set(std::move(p));
    }
    i = next;
  }
  return list;
}

}  // namespace kinora::rib
