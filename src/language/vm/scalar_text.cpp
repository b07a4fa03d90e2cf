// Text, point by point: messages, formats, pieces of strings, expressions, dictionaries. Formats and expressions that
// are the same for all points are read once.
#include <algorithm>

#include "language/library/dictionary.h"
#include "language/library/regex.h"
#include "language/library/string_hash.h"
#include "language/library/text.h"
#include "language/vm/scalar.h"

namespace kinora::language {

namespace {

// The arguments of a format for one point after the other.
class Formatter {
 public:
  Formatter(const Call& call, uint32_t first) : call_(call), first_(first), arguments_(call.count() - first - 1) {
    for (uint32_t k = first + 1; k < call.count(); ++k) {
      const Base base = call.base(k);
      kinds_.push_back(base == Base::Int                               ? FormatArgument::Kind::Int
                       : base == Base::String || base == Base::Closure ? FormatArgument::Kind::String
                                                                       : FormatArgument::Kind::Float);
      size_ += base == Base::Closure ? 1 : call.cells(k);
    }
    ints_.resize(size_);
    floats_.resize(size_);
    strings_.resize(size_);
  }
  // False when the format does not fit.
  bool text(uint32_t point, std::string& out) {
    const int32_t handle = call_.integer(first_, point);
    if (!isParsed_ || handle != handle_) {
      pieces_ = parseFormat(stringOf(handle));
      fits_ = checkFormat(pieces_, kinds_).empty();
      handle_ = handle;
      isParsed_ = true;
    }
    if (!fits_) return false;
    size_t at = 0;
    for (uint32_t k = first_ + 1; k < call_.count(); ++k) {
      FormatArgument& a = arguments_[k - first_ - 1];
      a.kind = kinds_[k - first_ - 1];
      a.count = call_.base(k) == Base::Closure ? 1 : int(call_.cells(k));
      a.ints = ints_.data() + at;
      a.floats = floats_.data() + at;
      a.strings = strings_.data() + at;
      for (uint32_t c = 0; c < uint32_t(a.count); ++c, ++at) {
        if (call_.base(k) == Base::Closure)
          strings_[at] = {};
        else if (a.kind == FormatArgument::Kind::String)
          strings_[at] = call_.text(k, point, c);
        else if (a.kind == FormatArgument::Kind::Int)
          ints_[at] = call_.integer(k, point, c);
        else
          floats_[at] = call_.number(k, point, c);
      }
    }
    out = formatText(pieces_, arguments_.data());
    return true;
  }

 private:
  const Call& call_;
  uint32_t first_;
  size_t size_ = 0;
  std::vector<FormatArgument> arguments_;
  std::vector<FormatArgument::Kind> kinds_;
  std::vector<int32_t> ints_;
  std::vector<float> floats_;
  std::vector<std::string_view> strings_;
  std::vector<FormatPiece> pieces_;
  int32_t handle_ = 0;
  bool isParsed_ = false, fits_ = false;
};

void misfit(const Call& call, uint32_t point) {
  const Executable& e = *call.f.run->program;
  tellOnce(call.f, call.siteNumber(), point, "a format that does not fit its arguments: " + placeOf(e, call.site()));
}

}  // namespace

void scalarPrintf(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  const MessageKind kind = MessageKind(call.extra() & 255);
  const bool isOwn = call.extra() & 256;  // not the shader's words
  const uint32_t first = kind == MessageKind::File ? 1 : 0;
  const Executable& e = *f.run->program;
  std::string prefix, text;
  if (kind == MessageKind::Error && !isOwn)
    prefix = "Shader error [" + SiteAccess::shader(e, call.site().layer) + "]: ";
  if (kind == MessageKind::Warning) prefix = "Shader warning [" + SiteAccess::shader(e, call.site().layer) + "]: ";
  Formatter formatter(call, first);
  for (uint32_t i = 0; i < f.points; ++i) {
    if (!call.isLive(i)) continue;
    if (isOwn && f.run->toldOnce[call.siteNumber()] && !f.run->tellsEveryPoint) break;
    if (isOwn && formatter.text(i, text))
      tellOnce(f, call.siteNumber(), i, text);
    else if (formatter.text(i, text))
      f.run->say(f.first + i, kind, prefix + text, first ? call.text(0, i) : std::string());
    else
      misfit(call, i);
  }
}
void scalarFormat(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  Formatter formatter(call, 1);
  std::string text;
  eachLive(call, [&](uint32_t i) {
    if (!formatter.text(i, text)) misfit(call, i), text.clear();
    call.set(0, i, internString(text));
  });
}
void scalarConcat(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  std::string all;
  eachLive(call, [&](uint32_t i) {
    all.clear();
    for (uint32_t k = 1; k < call.count() && all.size() < (1u << 24); ++k) all += call.text(k, i);
    call.set(0, i, internString(all));
  });
}
void scalarStrlen(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(call.text(1, i).size())); });
}
void scalarGetChar(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, language::getchar(call.text(1, i), call.integer(2, i))); });
}
void scalarStartsWith(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(startswith(call.text(1, i), call.text(2, i)))); });
}
void scalarEndsWith(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(endswith(call.text(1, i), call.text(2, i)))); });
}
void scalarSubstr(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    call.set(0, i, internString(language::substr(call.text(1, i), call.integer(2, i), call.integer(3, i))));
  });
}
void scalarStoI(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, language::stoi(call.text(1, i))); });
}
void scalarStoF(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, language::stof(call.text(1, i))); });
}
void scalarHashString(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) { call.set(0, i, hashString(call.text(1, i))); });
}
// result, text, pieces[], [separator, [most]]
void scalarSplit(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    const int room = int(call.cells(2));
    const int most = call.count() > 4 ? std::clamp(call.integer(4, i), 0, room) : room;
    const auto pieces =
        split(call.text(1, i), call.count() > 3 ? std::string_view(call.text(3, i)) : std::string_view(), most);
    for (size_t k = 0; k < pieces.size() && k < size_t(room); ++k)
      call.set(2, i, internString(pieces[k]), uint32_t(k));
    call.set(0, i, int32_t(std::min(pieces.size(), size_t(room))));
  });
}
// result, subject, [results[],] pattern
void scalarRegex(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  const bool results = call.count() == 4;
  std::vector<int32_t> found(results ? call.cells(2) : 0);
  std::string reason;
  eachLive(call, [&](uint32_t i) {
    const bool matches = matchRegex(call.text(1, i), call.text(call.count() - 1, i), call.extra() != 0, found.data(),
                                    int(found.size()), reason);
    for (size_t k = 0; k < found.size(); ++k) call.set(2, i, found[k], uint32_t(k));
    call.set(0, i, int32_t(matches));
    if (!reason.empty())
      tellOnce(f, call.siteNumber(), i,
               "regular expression: " + reason + ": " + placeOf(*f.run->program, call.site()));
  });
}
// node, text or node, query
void scalarDictFind(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  Dictionary* d = f.run->services->dictionary;
  eachLive(call, [&](uint32_t i) {
    int node = 0;
    if (d && call.base(1) == Base::Int)
      node = d->find(int(call.integer(1, i)), call.text(2, i));
    else if (d)
      node = d->find(std::string_view(call.text(1, i)), call.text(2, i));
    call.set(0, i, int32_t(node));
  });
}
void scalarDictNext(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  Dictionary* d = f.run->services->dictionary;
  eachLive(call, [&](uint32_t i) { call.set(0, i, int32_t(d ? d->next(call.integer(1, i)) : 0)); });
}
// found, node, attribute, value
void scalarDictValue(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  Dictionary* d = f.run->services->dictionary;
  const uint32_t n = call.cells(3);
  std::vector<int32_t> ints(n);
  std::vector<float> floats(n);
  eachLive(call, [&](uint32_t i) {
    bool found = false;
    if (d && call.base(3) == Base::String && n == 1) {
      std::string text;
      found = d->value(call.integer(1, i), call.text(2, i), text);
      if (found) call.set(3, i, internString(text));
    } else if (d && call.base(3) == Base::Int) {
      found = d->value(call.integer(1, i), call.text(2, i), ints.data(), int(n));
      for (uint32_t k = 0; found && k < n; ++k) call.set(3, i, ints[k], k);
    } else if (d && call.base(3) != Base::String) {
      found = d->value(call.integer(1, i), call.text(2, i), floats.data(), int(n));
      for (uint32_t k = 0; found && k < n; ++k) call.set(3, i, floats[k], k);
    }
    call.set(0, i, int32_t(found));
  });
}

}  // namespace kinora::language
