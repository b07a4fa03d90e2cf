#include "language/program/oso_reader.h"

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <unordered_map>

namespace kinora::language {

namespace {

constexpr size_t kLongestArray = 1u << 20, kMostSymbols = 1u << 20, kMostOps = 1u << 22, kDeepest = 400;

// One word of a line: plain, a "string" (unescaped), or a %hint{text}.
struct Word {
  enum Kind { Plain, String, Hint } kind = Plain;
  std::string text;  // Hint: its name
  std::string body;  // Hint: between the braces
};

char unescaped(char c) {
  switch (c) {
    case 'n':
      return '\n';
    case 't':
      return '\t';
    case 'r':
      return '\r';
    case 'a':
      return '\a';
    case 'b':
      return '\b';
    case 'f':
      return '\f';
    case 'v':
      return '\v';
    default:
      return c;
  }
}

// Reads a quoted string from text[at] == '"'; false when it does not end.
bool readString(std::string_view text, size_t& at, std::string& out) {
  out.clear();
  for (++at; at < text.size(); ++at) {
    if (text[at] == '"') {
      ++at;
      return true;
    }
    if (text[at] == '\\' && at + 1 < text.size()) {
      const char c = text[++at];
      if (c >= '0' && c <= '7') {
        int value = 0, digits = 0;
        while (digits < 3 && at < text.size() && text[at] >= '0' && text[at] <= '7')
          value = value * 8 + text[at++] - '0', ++digits;
        --at;
        out += char(value);
      } else {
        out += unescaped(c);
      }
    } else {
      out += text[at];
    }
  }
  return false;
}

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

const char* splitLine(std::string_view line, std::vector<Word>& words) {
  words.clear();
  for (size_t at = 0; at < line.size();) {
    if (isBlank(line[at])) {
      ++at;
      continue;
    }
    Word word;
    if (line[at] == '#') break;
    if (line[at] == '"') {
      word.kind = Word::String;
      if (!readString(line, at, word.text)) return "a string has no end";
    } else if (line[at] == '%') {
      word.kind = Word::Hint;
      const size_t first = ++at;
      while (at < line.size() && line[at] != '{' && !isBlank(line[at])) ++at;
      word.text = line.substr(first, at - first);
      if (at < line.size() && line[at] == '{') {
        const size_t body = ++at;
        std::string ignored;
        while (at < line.size() && line[at] != '}') {
          if (line[at] != '"')
            ++at;
          else if (!readString(line, at, ignored))
            return "a string has no end";
        }
        if (at >= line.size()) return "a hint has no closing brace";
        word.body = line.substr(body, at - body);
        ++at;
      }
    } else {
      const size_t first = at;
      while (at < line.size() && !isBlank(line[at])) ++at;
      word.text = line.substr(first, at - first);
    }
    words.push_back(std::move(word));
  }
  return nullptr;
}

// "a,b,\"c,d\"" -> a | b | c,d
std::vector<std::string> splitList(std::string_view body) {
  std::vector<std::string> parts;
  std::string part;
  for (size_t at = 0; at < body.size();) {
    if (body[at] == ',') {
      parts.push_back(std::move(part));
      part.clear();
      ++at;
    } else if (body[at] == '"') {
      std::string text;
      readString(body, at, text);
      part += text;
    } else {
      part += body[at++];
    }
  }
  parts.push_back(std::move(part));
  return parts;
}

bool toInt(std::string_view text, int64_t& value) {
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), value);
  return bad == std::errc() && end == text.data() + text.size();
}
bool toFloat(const std::string& text, float& value) {
  if (text.empty() || text.size() > 64) return false;
  const char* begin = text.c_str() + (text[0] == '+');
  const auto [end, bad] = std::from_chars(begin, text.c_str() + text.size(), value);
  if (end != text.c_str() + text.size()) return false;
  if (bad == std::errc::result_out_of_range) {  // too large: infinity; too small: 0
    double wide = 0;
    const auto [wideEnd, wideBad] = std::from_chars(begin, text.c_str() + text.size(), wide);
    value = wideBad == std::errc() ? float(wide) : 0.f;
    return wideEnd == end;
  }
  return bad == std::errc();
}

bool baseNamed(std::string_view name, Base& base) {
  static const std::unordered_map<std::string_view, Base> kBases = {
      {"void", Base::Void},     {"int", Base::Int},       {"float", Base::Float},
      {"string", Base::String}, {"color", Base::Color},   {"point", Base::Point},
      {"vector", Base::Vector}, {"normal", Base::Normal}, {"matrix", Base::Matrix}};
  const auto found = kBases.find(name);
  if (found == kBases.end()) return false;
  base = found->second;
  return true;
}

// "float[4]" -> base and length; the length alone when base is known.
bool splitArray(std::string_view text, std::string_view& name, int32_t& length) {
  const size_t open = text.find('[');
  name = text.substr(0, open);
  length = 0;
  if (open == std::string_view::npos) return true;
  if (text.back() != ']') return false;
  const std::string_view inside = text.substr(open + 1, text.size() - open - 2);
  if (inside.empty()) {
    length = -1;
    return true;
  }
  int64_t value = 0;
  if (!toInt(inside, value) || value < 1 || value > int64_t(kLongestArray)) return false;
  length = int32_t(value);
  return true;
}

struct RawOp {
  Opcode opcode = Opcode::Nop;
  std::vector<SymbolId> arguments;
  uint32_t jumps[4] = {};
  uint32_t jumpCount = 0;
  uint32_t fileLine = 0;  // of the .oso
  SourcePos pos;
};

struct Section {
  std::string name;
  uint32_t begin = 0, end = 0;
};

class Reader {
 public:
  Reader(std::string_view text, std::string_view fileName, Shader& shader, std::string& error)
      : text_(text), fileName_(fileName), shader_(shader), error_(error) {}

  bool read() {
    shader_ = Shader();
    error_.clear();
    if (!nextLine() || words_.size() < 2 || words_[0].text != "OpenShadingLanguage")
      return fail("not an .oso file: its first line must be `OpenShadingLanguage 1.00`");
    if (words_[1].text.rfind("1.", 0) != 0)
      return fail("version " + words_[1].text + " of the .oso format is not known; 1.00 is");
    if (!nextLine()) return error_.empty() ? fail("the file ends before the shader's name") : false;
    if (!header()) return false;
    bool more = nextLine();
    while (more && words_[0].text != "code") {
      if (!symbol()) return false;
      more = nextLine();
    }
    if (!error_.empty()) return false;
    if (!joinStructs()) return false;
    bool ended = false;
    for (; more && !ended; more = nextLine()) {
      if (words_[0].kind == Word::Hint) break;  // %preprocessed_source
      if (words_[0].text == "code" && words_.size() >= 2) {
        if (!section()) return false;
      } else if (sections_.empty()) {
        return fail("expected `code`");
      } else {
        if (!operation()) return false;
        ended = ops_.back().opcode == Opcode::End;
      }
    }
    if (!error_.empty()) return false;
    if (sections_.empty() || sections_.back().name != "___main___")
      return fail("the file is truncated: there is no code section ___main___");
    if (!ended) return fail("the file is truncated: the code has no `end`");
    sections_.back().end = uint32_t(ops_.size()) - 1;
    return build();
  }

 private:
  bool fail(const std::string& what, uint32_t line = 0) {
    if (error_.empty())
      error_ = std::string(fileName_) + ":" + std::to_string(line ? line : line_) + ": error: " + what;
    return false;
  }

  // The next line that is not empty, in words_. False at the end of the text or after an error.
  bool nextLine() {
    while (at_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', at_), text_.size());
      const std::string_view line = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_;
      if (const char* wrong = splitLine(line, words_)) return fail(wrong);
      if (!words_.empty()) return true;
    }
    return false;
  }

  bool metadata(const Word& word, std::vector<Metadata>& list) {
    const std::vector<std::string> parts = splitList(word.body);
    Metadata meta;
    std::string_view base;
    if (parts.size() < 2 || !splitArray(parts[0], base, meta.type.arrayLength) || !baseNamed(base, meta.type.base))
      return fail("metadata that cannot be read: %meta{" + word.body + "}");
    meta.name = parts[1];
    for (size_t i = 2; i < parts.size(); ++i)
      if (!addValue(meta.type.base, parts[i], meta.values))
        return fail("metadata `" + meta.name + "`: `" + parts[i] + "` is no value of its type");
    list.push_back(std::move(meta));
    return true;
  }

  static bool addValue(Base base, const std::string& text, Values& values) {
    if (base == Base::String) {
      values.strings.push_back(text);
    } else if (base == Base::Int) {
      int64_t value = 0;
      if (!toInt(text, value) || value < INT32_MIN || value > int64_t(UINT32_MAX)) return false;
      values.ints.push_back(int32_t(uint32_t(value)));
    } else {
      float value = 0;
      if (!toFloat(text, value)) return false;
      values.floats.push_back(value);
    }
    return true;
  }

  bool header() {
    static const std::unordered_map<std::string_view, ShaderKind> kKinds = {
        {"shader", ShaderKind::Shader},
        {"surface", ShaderKind::Surface},
        {"displacement", ShaderKind::Displacement},
        {"volume", ShaderKind::Volume},
        {"light", ShaderKind::Surface}};
    const auto kind = kKinds.find(words_[0].text);
    if (kind == kKinds.end() || words_.size() < 2 || words_[1].kind != Word::Plain)
      return fail("expected the kind of shader and its name");
    shader_.kind = kind->second;
    shader_.name = words_[1].text;
    for (size_t i = 2; i < words_.size(); ++i)
      if (words_[i].kind == Word::Hint && words_[i].text == "meta" && !metadata(words_[i], shader_.metadata))
        return false;
    return true;
  }

  bool symbol() {
    static const std::unordered_map<std::string_view, SymbolKind> kKinds = {
        {"param", SymbolKind::Param}, {"oparam", SymbolKind::OutputParam}, {"local", SymbolKind::Local},
        {"temp", SymbolKind::Temp},   {"global", SymbolKind::Global},      {"const", SymbolKind::Constant}};
    const auto kind = kKinds.find(words_[0].text);
    if (kind == kKinds.end()) return fail("`" + words_[0].text + "` is no kind of symbol");
    if (shader_.symbols.size() >= kMostSymbols) return fail("more symbols than can be held");
    Symbol symbol;
    symbol.kind = kind->second;
    size_t at = 1;
    std::string structName;
    if (words_.size() > 2 && words_[1].text == "closure") {
      std::string_view name;
      if (!splitArray(words_[2].text, name, symbol.type.arrayLength) || name != "color")
        return fail("expected `closure color`");
      symbol.type.base = Base::Closure;
      at = 3;
    } else if (words_.size() > 2 && words_[1].text == "struct") {
      std::string_view name;
      if (!splitArray(words_[2].text, name, symbol.type.arrayLength))
        return fail("an array length that is not between 1 and 1048576");
      structName = name;
      symbol.type.base = Base::Struct;
      at = 3;
    } else {
      std::string_view name;
      if (words_.size() < 3 || !splitArray(words_[1].text, name, symbol.type.arrayLength))
        return fail("a symbol needs a type, with an array length between 1 and 1048576, and a name");
      if (!baseNamed(name, symbol.type.base)) return fail("`" + words_[1].text + "` is no type");
      at = 2;
    }
    if (at >= words_.size() || words_[at].kind != Word::Plain) return fail("a symbol has no name");
    symbol.name = words_[at++].text;
    const size_t perElement = size_t(componentsOf(symbol.type.base));
    const size_t most = symbol.type.arrayLength < 0 ? kLongestArray * perElement
                                                    : perElement * size_t(std::max(1, symbol.type.arrayLength));
    size_t given = 0;
    for (; at < words_.size() && words_[at].kind != Word::Hint; ++at, ++given) {
      if (perElement == 0) continue;  // closures and structs have no literal value
      if (given >= most) return fail("`" + symbol.name + "` has more values than its type holds");
      if ((words_[at].kind == Word::String) != (symbol.type.base == Base::String) ||
          !addValue(symbol.type.base, words_[at].text, symbol.values))
        return fail("`" + words_[at].text + "` is no value for `" + symbol.name + "` of type " + nameOf(symbol.type));
    }
    if (symbol.kind == SymbolKind::Constant && given == 0) return fail("constant `" + symbol.name + "` has no value");
    const bool hasValue = symbol.kind == SymbolKind::Param || symbol.kind == SymbolKind::OutputParam ||
                          symbol.kind == SymbolKind::Constant;
    if (hasValue && symbol.type.arrayLength >= 0 && perElement) {
      if (symbol.type.base == Base::String)
        symbol.values.strings.resize(most);
      else if (symbol.type.base == Base::Int)
        symbol.values.ints.resize(most);
      else if (isTriple(symbol.type.base) && given == 1)
        symbol.values.floats.resize(3, symbol.values.floats[0]);
      else
        symbol.values.floats.resize(most);
    } else if (!hasValue) {
      symbol.values = Values();
    }
    std::string owner;
    int64_t field = -1;
    for (; at < words_.size(); ++at) {
      const Word& hint = words_[at];
      if (hint.kind != Word::Hint) return fail("a value behind the hints of `" + symbol.name + "`");
      if (hint.text == "meta" && !metadata(hint, symbol.metadata)) return false;
      if (hint.text == "initexpr") symbol.hasInitCode = true;
      if (hint.text == "structfields" && !structure(structName, hint, symbol)) return false;
      if (hint.text == "mystruct") owner = hint.body;
      if (hint.text == "mystructfield" && (!toInt(hint.body, field) || field < 0))
        return fail("a field's number that cannot be read");
    }
    for (const Metadata& meta : symbol.metadata) {
      if (meta.values.ints.empty()) continue;
      if (meta.name == "lockgeom") symbol.lockGeometry = meta.values.ints[0] != 0;
      if (meta.name == "interpolated") symbol.lockGeometry = meta.values.ints[0] == 0;
    }
    if (symbol.type.base == Base::Struct && symbol.type.structure < 0) {
      for (size_t i = 0; i < shader_.structures.size(); ++i)
        if (shader_.structures[i].name == structName) symbol.type.structure = int32_t(i);
      if (symbol.type.structure < 0) return fail("struct `" + structName + "` is not described");
    }
    if (!owner.empty()) {
      const auto found = byName_.find(owner);
      if (found == byName_.end() || shader_.symbols[size_t(found->second)].type.base != Base::Struct)
        return fail("`" + symbol.name + "` names a struct `" + owner + "` that is not there");
      symbol.ofStruct = found->second;
      symbol.field = int32_t(field);
    }
    if (!byName_.emplace(symbol.name, SymbolId(shader_.symbols.size())).second)
      return fail("symbol `" + symbol.name + "` stands twice");
    shader_.symbols.push_back(std::move(symbol));
    return true;
  }

  bool structure(const std::string& name, const Word& hint, Symbol& symbol) {
    for (size_t i = 0; i < shader_.structures.size(); ++i)
      if (shader_.structures[i].name == name) {
        symbol.type.structure = int32_t(i);
        return true;
      }
    Structure made;
    made.name = name;
    for (const std::string& field : splitList(hint.body)) made.fields.push_back({field, Type()});
    symbol.type.structure = int32_t(shader_.structures.size());
    shader_.structures.push_back(std::move(made));
    return true;
  }

  // Fields' types are those of the symbols that hold them.
  bool joinStructs() {
    for (const Symbol& symbol : shader_.symbols) {
      if (symbol.ofStruct == kNone) continue;
      const Symbol& owner = shader_.symbols[size_t(symbol.ofStruct)];
      Structure& structure = shader_.structures[size_t(owner.type.structure)];
      if (symbol.field < 0 || size_t(symbol.field) >= structure.fields.size())
        return fail("`" + symbol.name + "` is no field of struct `" + structure.name + "`");
      Type type = symbol.type;
      if (owner.type.arrayLength != 0 && symbol.type.arrayLength == owner.type.arrayLength) type.arrayLength = 0;
      structure.fields[size_t(symbol.field)].type = type;
    }
    orderStructs();
    return true;
  }

  // Structs behind those that they hold: a file describes the outer one first. One that holds itself keeps its place
  // behind all others, which invalid() tells.
  void orderStructs() {
    std::vector<Structure>& all = shader_.structures;
    const auto isHeld = [&](const Type& t) {
      return t.base == Base::Struct && t.structure >= 0 && size_t(t.structure) < all.size();
    };
    std::vector<std::vector<size_t>> holders(all.size());
    std::vector<size_t> waitsFor(all.size(), 0), order;
    for (size_t i = 0; i < all.size(); ++i)
      for (const Field& f : all[i].fields)
        if (isHeld(f.type)) {
          holders[size_t(f.type.structure)].push_back(i);
          ++waitsFor[i];
        }
    for (size_t i = 0; i < all.size(); ++i)
      if (waitsFor[i] == 0) order.push_back(i);
    for (size_t k = 0; k < order.size(); ++k)
      for (const size_t holder : holders[order[k]])
        if (--waitsFor[holder] == 0) order.push_back(holder);
    for (size_t i = 0; i < all.size(); ++i)
      if (waitsFor[i] > 0) order.push_back(i);
    std::vector<int32_t> place(all.size());
    std::vector<Structure> ordered;
    for (const size_t i : order) {
      place[i] = int32_t(ordered.size());
      ordered.push_back(all[i]);
    }
    const auto move = [&](Type& t) {
      if (isHeld(t)) t.structure = place[size_t(t.structure)];
    };
    for (Structure& structure : ordered)
      for (Field& f : structure.fields) move(f.type);
    for (Symbol& symbol : shader_.symbols) move(symbol.type);
    all = std::move(ordered);
  }

  bool section() {
    const std::string& name = words_[1].text;
    if (!sections_.empty()) {
      if (sections_.back().name == "___main___") return fail("code behind ___main___");
      sections_.back().end = uint32_t(ops_.size());
    }
    if (name != "___main___") {
      const auto found = byName_.find(name);
      if (found == byName_.end()) return fail("code for `" + name + "`, which is no parameter");
      Symbol& symbol = shader_.symbols[size_t(found->second)];
      if (symbol.kind != SymbolKind::Param && symbol.kind != SymbolKind::OutputParam)
        return fail("code for `" + name + "`, which is no parameter");
      symbol.hasInitCode = true;
      for (const Section& other : sections_)
        if (other.name == name) return fail("code for `" + name + "` stands twice");
    }
    sections_.push_back({name, uint32_t(ops_.size()), 0});
    return true;
  }

  static uint32_t jumpsOf(Opcode op) {
    switch (op) {
      case Opcode::If:
        return 2;
      case Opcode::For:
      case Opcode::While:
      case Opcode::DoWhile:
        return 4;
      case Opcode::Call:
        return 1;
      default:
        return 0;
    }
  }

  bool operation() {
    RawOp op;
    op.fileLine = line_;
    op.opcode = opcodeNamed(words_[0].text);
    if (op.opcode == Opcode::Count) return fail("operation `" + words_[0].text + "` is not known");
    if (ops_.size() >= kMostOps) return fail("more operations than can be held");
    size_t end = 1;
    while (end < words_.size() && words_[end].kind != Word::Hint) ++end;
    op.jumpCount = jumpsOf(op.opcode);
    if (end - 1 < op.jumpCount) return fail("`" + words_[0].text + "` lacks its jumps");
    const size_t lastArgument = end - op.jumpCount;
    for (size_t i = 1; i < lastArgument; ++i) {
      const auto found = byName_.find(words_[i].text);
      if (found == byName_.end()) return fail("`" + words_[i].text + "` is no symbol");
      op.arguments.push_back(found->second);
    }
    for (size_t i = lastArgument; i < end; ++i) {
      int64_t jump = 0;
      if (!toInt(words_[i].text, jump) || jump < 0 || jump > int64_t(kMostOps))
        return fail("a jump that cannot be read: `" + words_[i].text + "`");
      op.jumps[i - lastArgument] = uint32_t(jump);
    }
    for (size_t i = end; i < words_.size(); ++i) {
      if (words_[i].kind != Word::Hint) return fail("an argument behind the hints");
      if (words_[i].text == "filename") {
        const std::vector<std::string> name = splitList(words_[i].body);
        sourceFile_ = FileName(name[0]);
      } else if (words_[i].text == "line") {
        int64_t line = 0;
        if (toInt(words_[i].body, line) && line >= 0 && line < INT32_MAX) sourceLine_ = uint32_t(line);
      }
    }
    op.pos = {sourceFile_, sourceLine_};
    const std::string_view letters = factsOf(op.opcode).letters;
    const size_t fixed = letters.ends_with('*') ? letters.size() - 2 : letters.size();
    if (op.arguments.size() < fixed || (!letters.ends_with('*') && op.arguments.size() > fixed))
      return fail("`" + words_[0].text + "` has " + std::to_string(op.arguments.size()) + " arguments");
    ops_.push_back(std::move(op));
    return true;
  }

  bool block(uint32_t begin, uint32_t end, size_t depth, Block& out) {
    if (depth > kDeepest) return fail("blocks nested deeper than " + std::to_string(kDeepest));
    for (uint32_t at = begin; at < end;) {
      RawOp& op = ops_[at];
      if (op.opcode == Opcode::Nop || op.opcode == Opcode::End || op.opcode == Opcode::UseParam) {
        ++at;
        continue;
      }
      Instruction made;
      made.opcode = op.opcode;
      made.arguments = op.arguments;
      made.pos = op.pos;
      // other compilers assign arrays as they assign values
      if (op.opcode == Opcode::Assign && op.arguments.size() == 2 &&
          shader_.symbols[size_t(op.arguments[0])].type.arrayLength != 0)
        made.opcode = Opcode::ArrayCopy;
      uint32_t edges[6] = {at + 1};
      for (uint32_t j = 0; j < op.jumpCount; ++j) {
        edges[j + 1] = op.jumps[j];
        if (edges[j + 1] < edges[j] || edges[j + 1] > end)
          return fail("a jump to " + std::to_string(op.jumps[j]) + " leaves its block", op.fileLine);
      }
      for (uint32_t j = 0; j < op.jumpCount; ++j) {
        made.blocks.emplace_back();
        if (!block(edges[j], edges[j + 1], depth + 1, made.blocks.back())) return false;
      }
      out.code.push_back(std::move(made));
      at = op.jumpCount ? edges[op.jumpCount] : at + 1;
    }
    return true;
  }

  bool build() {
    for (const Section& section : sections_) {
      if (section.name == "___main___") {
        if (!block(section.begin, section.end, 0, shader_.main)) return false;
      } else {
        Initialiser initialiser;
        initialiser.parameter = byName_.at(section.name);
        if (!block(section.begin, section.end, 0, initialiser.code)) return false;
        shader_.initialisers.push_back(std::move(initialiser));
      }
    }
    return true;
  }

  std::string_view text_, fileName_;
  Shader& shader_;
  std::string& error_;
  size_t at_ = 0;
  uint32_t line_ = 0;
  std::vector<Word> words_;
  std::unordered_map<std::string, SymbolId> byName_;
  std::vector<Section> sections_;
  std::vector<RawOp> ops_;
  FileName sourceFile_;
  uint32_t sourceLine_ = 0;
};

}  // namespace

bool readOso(std::string_view text, std::string_view fileName, Shader& shader, std::string& error) {
  if (!Reader(text, fileName, shader, error).read()) return false;
  const std::string wrong = invalid(shader);
  if (!wrong.empty()) error = std::string(fileName) + ": error: " + wrong;
  return wrong.empty();
}

}  // namespace kinora::language
