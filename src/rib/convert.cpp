#include "rib/convert.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <set>
#include <unordered_map>

#include "rib/archive_search.h"
#include "rib/interpreter.h"
#include "rib/lexer.h"
#include "rib/words.h"

namespace kinora::rib {

namespace {

constexpr size_t kFlush = 1 << 16;
constexpr size_t kColumns = 110;  // where lines of ASCII break, between values

}  // namespace

// Requests as bytes. Both forms read back to the same requests, values and types.
class Encoder {
 public:
  explicit Encoder(const Converter::Sink& sink) : sink_(sink) {}
  virtual ~Encoder() = default;
  virtual void request(const Request& r) = 0;
  void flush() {
    if (!out_.empty()) sink_(out_);
    out_.clear();
  }

 protected:
  void flushWhenFull() {
    if (out_.size() > kFlush) flush();
  }
  std::string out_;

 private:
  const Converter::Sink& sink_;
};

class Ascii : public Encoder {
 public:
  using Encoder::Encoder;
  void request(const Request& r) override {
    if (!isBegun_) out_ = "##RenderMan RIB-Structure 1.1\n";  // of what there is; a file that is not has none
    isBegun_ = true;
    const bool closes = r.name.ends_with("End") && r.name.size() > 3, opens = r.name.ends_with("Begin");
    if (closes && depth_ > 0) --depth_;
    indent_ = std::min<size_t>(depth_, 20) * 2;
    out_.append(indent_, ' ');
    out_ += r.name;
    column_ = indent_ + r.name.size();
    for (size_t i = 0; i < r.count; ++i) argument(r.args[i]);
    out_ += '\n';
    if (opens) ++depth_;
    flushWhenFull();
  }

 private:
  void value(std::string_view text, bool isFirst) {
    if (column_ + text.size() + 1 > kColumns && column_ > indent_ + 4) {
      out_ += '\n';
      out_.append(indent_ + 4, ' ');
      column_ = indent_ + 4;
    } else if (!isFirst) {
      out_ += ' ';
      ++column_;
    }
    out_ += text;
    column_ += text.size();
    flushWhenFull();
  }
  void argument(const Argument& a) {
    out_ += ' ';
    ++column_;
    if (a.isArray) out_ += '[', ++column_;
    if (a.kind == Argument::Kind::Strings)
      for (size_t i = 0; i < a.strings.size(); ++i) value(quoted(a.strings[i]), i == 0);
    else if (a.isInteger)
      for (size_t i = 0; i < a.ints.size(); ++i) value(number(a.ints[i]), i == 0);
    else
      reals(a);
    if (a.isArray) out_ += ']', ++column_;
  }
  // Numbers that were not all integers must not read back as such.
  void reals(const Argument& a) {
    bool isSeen = false;
    for (size_t i = 0; i < a.floats.size(); ++i) {
      const bool isExact = i < a.exact.size() && float(a.exact[i]) == a.floats[i];
      // what a float holds exactly came from one, in binary files: it is written as short as a float
      const bool isWide = isExact && double(float(a.exact[i])) != a.exact[i];
      std::string text = isWide ? number(a.exact[i]) : number(isExact ? float(a.exact[i]) : a.floats[i]);
      isSeen |= text.find_first_of(".en") != std::string::npos;
      if (i + 1 == a.floats.size() && !isSeen) text += ".0";
      value(text, i == 0);
    }
  }
  template <class T>
  static std::string number(T v) {
    std::string text;
    appendNumber(v, text);
    return text;
  }
  static std::string quoted(std::string_view s) {
    std::string text;
    appendString(s, text);
    return text;
  }
  size_t depth_ = 0, indent_ = 0, column_ = 0;
  bool isBegun_ = false;
};

// The table of section 1.1 of the RIB reference; numbers are octal there and here.
class Binary : public Encoder {
 public:
  using Encoder::Encoder;
  void request(const Request& r) override {
    const auto [it, isNew] = codes_.try_emplace(r.name, codes_.size());
    if (it->second < 256) {
      if (isNew) {
        byte(0314);
        byte(unsigned(it->second));
        plain(r.name);
      }
      byte(0246);
      byte(unsigned(it->second));
    } else {  // more names than codes: nonsense streams only
      out_ += '\n' + r.name + ' ';
    }
    for (size_t i = 0; i < r.count; ++i) argument(r.args[i]);
    flushWhenFull();
  }

 private:
  void byte(unsigned v) { out_ += char(static_cast<unsigned char>(v)); }
  void bigEndian(uint64_t v, int count) {
    for (int i = count - 1; i >= 0; --i) byte(unsigned(v >> (8 * i)) & 255);
  }
  static int bytesOf(uint64_t v) { return v < (1u << 8) ? 1 : v < (1u << 16) ? 2 : v < (1u << 24) ? 3 : 4; }
  void plain(const std::string& s) {
    if (s.size() < 16) {
      byte(0220 + unsigned(s.size()));
    } else {
      const int w = bytesOf(s.size());
      byte(0240 + unsigned(w - 1));
      bigEndian(s.size(), w);
    }
    out_ += s;
  }
  // Parameter names come again and again: the second time they get a token of two or three bytes.
  void string(const std::string& s) {
    constexpr size_t kMostTokens = 65536, kLongest = 256;
    if (s.size() > kLongest || s.size() < 3) return plain(s);
    if (seen_.size() >= kMostTokens && !seen_.contains(s)) return plain(s);
    const auto [it, isNew] = seen_.try_emplace(s, kNoToken);
    if (isNew) return plain(s);
    if (it->second == kNoToken) {
      it->second = tokens_++;
      byte(it->second < 256 ? 0315u : 0316u);
      bigEndian(it->second, it->second < 256 ? 1 : 2);
      plain(s);
    }
    byte(it->second < 256 ? 0317u : 0320u);
    bigEndian(it->second, it->second < 256 ? 1 : 2);
  }
  void integer(int v) {
    int w = 1;
    while (w < 4 && (v < -(1 << (8 * w - 1)) || v >= 1 << (8 * w - 1))) ++w;
    byte(0200 + unsigned(w - 1));
    bigEndian(uint32_t(v), w);
  }
  void real(double v) {
    const float f = float(v);
    if (double(f) == v || std::isnan(v)) {
      byte(0244);
      bigEndian(std::bit_cast<uint32_t>(f), 4);
    } else {
      byte(0245);
      bigEndian(std::bit_cast<uint64_t>(v), 8);
    }
  }
  void argument(const Argument& a) {
    if (a.kind == Argument::Kind::Strings || a.isInteger) {
      if (a.isArray) out_ += '[';
      for (const std::string& s : a.strings) string(s), flushWhenFull();
      if (a.kind == Argument::Kind::Numbers)
        for (const int v : a.ints) integer(v), flushWhenFull();
      if (a.isArray) out_ += ']';
      return;
    }
    // short ones may be matrices and times, which are kept in full
    constexpr size_t kShort = Argument::kExactKept;
    if (!a.isArray || a.floats.size() <= kShort) {
      if (a.isArray) out_ += '[';
      for (size_t i = 0; i < a.floats.size(); ++i) {
        const bool isExact = i < a.exact.size() && float(a.exact[i]) == a.floats[i];
        real(isExact ? a.exact[i] : double(a.floats[i]));
      }
      if (a.isArray) out_ += ']';
      return;
    }
    const int w = bytesOf(a.floats.size());
    byte(0310 + unsigned(w - 1));
    bigEndian(a.floats.size(), w);
    for (const float f : a.floats) {
      bigEndian(std::bit_cast<uint32_t>(f), 4);
      flushWhenFull();
    }
  }
  static constexpr size_t kNoToken = SIZE_MAX;
  std::unordered_map<std::string, size_t> codes_, seen_;
  size_t tokens_ = 0;
};

struct Converter::Impl {
  Diagnostics& messages;
  ConvertOptions options;
  Sink sink;
  std::unique_ptr<Encoder> encoder;
  struct Source {
    std::unique_ptr<Lexer> lexer;
    std::string identity;
    bool isScoped = false;  // a delayed archive leaves the graphics state as it was
  };
  std::vector<Source> sources;
  std::string ownPath, mainDirectory;
  Dirmap ownDirmap;
  std::set<std::string> inlineArchives;
  int reads = 0;

  Impl(Diagnostics& m, ConvertOptions o, Sink s) : messages(m), options(std::move(o)), sink(std::move(s)) {
    if (options.binary)
      encoder = std::make_unique<Binary>(sink);
    else
      encoder = std::make_unique<Ascii>(sink);
  }

  static std::string identityOf(const std::string& file) {
    std::error_code failed;
    const auto canonical = std::filesystem::weakly_canonical(file, failed);
    return failed ? file : canonical.string();
  }
  void plainRequest(const char* name, const SourcePos& pos) {
    Request r;
    r.name = name;
    r.pos = pos;
    encoder->request(r);
  }

  bool run(Source first) {
    bool any = false;
    sources.push_back(std::move(first));
    Request r;
    while (!sources.empty()) {
      if (sources.back().lexer->readRequest(r)) {
        any = true;
        note(r);
        if (!options.expand || !expanded(r)) encoder->request(r);
        continue;
      }
      if (sources.back().isScoped) plainRequest("AttributeEnd", {});
      sources.pop_back();
    }
    return any;
  }

  // What decides where archives are.
  void note(const Request& r) {
    if (r.name == "ArchiveBegin" && r.count > 0 && r.args[0].isString()) inlineArchives.insert(r.args[0].strings[0]);
    if (r.name != "Option" || r.count < 3 || !r.args[0].isString() || r.args[0].strings[0] != "searchpath") return;
    for (size_t i = 1; i + 1 < r.count; i += 2)
      if (r.args[i].isString() && r.args[i].strings[0].ends_with("archive") && r.args[i + 1].isString())
        ownPath = withEnvironment(r.args[i + 1].strings[0]);
      else if (r.args[i].isString() && r.args[i].strings[0].ends_with("dirmap") && r.args[i + 1].isString())
        readDirmap(r.args[i + 1].strings[0], ownDirmap);
  }

  // True when the request's archive is read in its place.
  bool expanded(const Request& r) {
    std::string name;
    bool isScoped = false;
    if (r.name == "ReadArchive" && r.count > 0 && r.args[0].isString()) {
      name = r.args[0].strings[0];
    } else if (r.name == "Procedural" && r.count > 1 && r.args[0].isString() && !r.args[1].strings.empty() &&
               r.args[0].strings[0] == "DelayedReadArchive") {
      name = r.args[1].strings[0];
      isScoped = true;
    }
    if (name.empty() || inlineArchives.contains(name)) return false;
    Dirmap dirmap = options.dirmap;
    dirmap.insert(dirmap.end(), ownDirmap.begin(), ownDirmap.end());
    const std::string file =
        ArchiveSearch{expandSearchPath(ownPath, options.archivePath), dirmap, mainDirectory}.find(
            name, sources.back().lexer->name());
    std::string why = "is not found";
    auto source = file.empty() ? nullptr : openFile(file, why);
    if (!source) {
      messages.warning("ASSET-MISSING-ARCHIVE", r.pos, "the archive '" + name.substr(0, 200) + "' " + why,
                       "the request that reads it is kept",
                       "give its folder by --search-path archive=DIR or Option \"searchpath\" \"archive\"");
      return false;
    }
    Source s;
    s.identity = identityOf(file);
    s.isScoped = isScoped;
    for (const Source& open : sources)
      if (open.identity == s.identity) {
        messages.error("RIB-RECURSION", r.pos, "the archive '" + name.substr(0, 200) + "' reads itself",
                       "the request that reads it is kept");
        return false;
      }
    constexpr size_t kMostDepth = 64;
    constexpr int kMostReads = 1000000;
    if (sources.size() > kMostDepth || ++reads > kMostReads) {
      messages.error("RIB-DEPTH", r.pos, "archives are nested too deeply or are too many",
                     "the request that reads it is kept");
      return false;
    }
    s.lexer = std::make_unique<Lexer>(std::move(source), file, messages, &Interpreter::isRequest);
    if (isScoped) plainRequest("AttributeBegin", r.pos);
    sources.push_back(std::move(s));
    return true;
  }
};

Converter::Converter(Diagnostics& messages, ConvertOptions options, Sink sink)
    : impl_(std::make_unique<Impl>(messages, std::move(options), std::move(sink))) {}
Converter::~Converter() = default;

bool Converter::file(const std::string& given) {
  Impl& m = *impl_;
  std::string why;
  const std::string path = sceneIn(given, why);
  if (path.empty()) {
    m.messages.error("RIB-ZIP", {}, "'" + given + "' " + why, "nothing is converted",
                     "name a member: " + given + "!FILE.rib");
    return false;
  }
  auto source = openFile(path, why);
  if (!source) {
    const bool isDirectory = why == "is a directory";
    m.messages.error(isDirectory ? "RIB-DIRECTORY" : "RIB-OPEN", {},
                     "'" + path + "' cannot be read: it " + (isDirectory ? why : "gives \"" + why + "\""),
                     "nothing is converted");
    return false;
  }
  m.mainDirectory = folderOf(given);
  Impl::Source s;
  s.lexer =
      std::make_unique<Lexer>(std::move(source), path == "-" ? "stdin" : path, m.messages, &Interpreter::isRequest);
  s.identity = Impl::identityOf(path);
  if (m.run(std::move(s))) return true;
  m.messages.error("RIB-EMPTY", {FileName(path), 0}, "the file holds no request", "nothing is converted");
  return false;
}

bool Converter::text(const std::string& name, std::string rib) {
  Impl::Source s;
  s.lexer = std::make_unique<Lexer>(openText(std::move(rib)), name, impl_->messages, &Interpreter::isRequest);
  s.identity = name;
  return impl_->run(std::move(s));
}

void Converter::finish() { impl_->encoder->flush(); }

}  // namespace kinora::rib
