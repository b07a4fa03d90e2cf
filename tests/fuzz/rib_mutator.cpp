#include "fuzz/rib_mutator.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstddef>
#include <cstdlib>

#include "fuzz/rib_grammar.h"
#include "fuzz/rib_input.h"

namespace kinora::fuzz {

namespace {

constexpr size_t kMostRepeats = 300;

std::string bigEndian(uint64_t v, int bytes) {
  std::string s;
  for (int i = bytes - 1; i >= 0; --i) s += char(v >> (8 * i));
  return s;
}

// Indices of the tokens of a kind.
std::vector<size_t> all(const std::vector<Token>& t, Token::Kind kind) {
  std::vector<size_t> at;
  for (size_t i = 0; i < t.size(); ++i)
    if (t[i].kind == kind) at.push_back(i);
  return at;
}

// Where requests begin, and the end.
std::vector<size_t> requestsOf(const std::vector<Token>& t) {
  std::vector<size_t> at = all(t, Token::Kind::Word);
  at.push_back(t.size());
  return at;
}

Token make(Token::Kind kind, std::string text) { return {kind, std::move(text)}; }

}  // namespace

std::vector<Token> tokensOf(std::string_view s) {
  using enum Token::Kind;
  std::vector<Token> out;
  const auto take = [&](Token::Kind kind, size_t& at, size_t end) {
    out.push_back({kind, std::string(s.substr(at, end - at))});
    at = end;
  };
  const auto isEnd = [&](size_t i) {
    const auto c = static_cast<unsigned char>(s[i]);
    return std::isspace(c) || c == '[' || c == ']' || c == '"' || c == '#' || c >= 128;
  };
  for (size_t i = 0; i < s.size();) {
    const auto c = static_cast<unsigned char>(s[i]);
    size_t end = i + 1;
    if (c == '#') {
      take(Space, i, std::min(s.find('\n', i), s.size()));
    } else if (std::isspace(c)) {
      while (end < s.size() && std::isspace(static_cast<unsigned char>(s[end]))) ++end;
      take(Space, i, end);
    } else if (c == '"') {
      while (end < s.size() && s[end] != '"') end += s[end] == '\\' ? 2 : 1;
      take(String, i, std::min(end + 1, s.size()));
    } else if (c == '[' || c == ']') {
      take(c == '[' ? Open : Close, i, end);
    } else {
      while (c < 128 && end < s.size() && !isEnd(end)) ++end;
      take(c >= 128 ? Other : std::isalpha(c) ? Word : Number, i, end);
    }
  }
  return out;
}

std::string textOf(const std::vector<Token>& tokens) {
  std::string s;
  for (const Token& t : tokens) s += t.text;
  return s;
}

std::string RibMutator::number() {
  switch (below(4)) {
    case 0:
      return std::to_string(int(below(9)) - 1);
    case 1:
      return std::to_string(below(2000) / 100.0 - 10);
    default:
      return kNumbers[below(std::size(kNumbers))];
  }
}

std::string RibMutator::string() {
  if (below(40) == 0) return "\"" + std::string(below(70000), char(32 + below(95))) + "\"";
  return "\"" + std::string(kStrings[below(std::size(kStrings))]) + "\"";
}

std::string RibMutator::value(char kind) {
  std::string s;
  const size_t n = below(8) == 0 ? below(40) : 1 + below(4);
  switch (kind) {
    case 'n':
      return number();
    case 's':
      return string();
    case 'N':
      for (size_t i = 0; i < n; ++i) s += number() + " ";
      return "[" + s + "]";
    case 'S':
      for (size_t i = 0; i < n; ++i) s += string() + " ";
      return "[" + s + "]";
    case 'P':  // a parameter
      s = "\"" + std::string(kDeclarations[below(std::size(kDeclarations))]) + "\" ";
      if (below(30) == 0) return s;
      return s + value(below(4) == 0 ? 'S' : 'N');
    default:
      return {};
  }
}

std::string RibMutator::request() {
  const RequestShape& shape = kRequests[below(std::size(kRequests))];
  std::string s = std::string("\n") + shape.name + " ";
  for (const char* k = shape.arguments; *k; ++k) {
    if (*k == '*') {
      for (size_t i = below(4); i > 0; --i) s += value('P') + " ";
    } else if (below(25) != 0) {
      s += value(*k) + " ";
    }
  }
  return s + "\n";
}

void RibMutator::mutateArray(std::vector<Token>& t) {
  const auto opens = all(t, Token::Kind::Open);
  if (opens.empty()) return;
  const size_t open = opens[below(opens.size())];
  size_t close = open + 1;
  while (close < t.size() && t[close].kind != Token::Kind::Close && t[close].kind != Token::Kind::Open) ++close;
  if (close == t.size()) return;
  const auto at = [&](size_t i) { return t.begin() + ptrdiff_t(i); };
  const std::vector<Token> inside(at(open + 1), at(close));
  switch (below(8)) {
    case 0:
      t.erase(at(open + 1), at(close));
      break;
    case 1:  // shorter
      t.erase(at(open + 1 + below(inside.size() + 1)), at(close));
      break;
    case 2: {  // longer
      for (size_t i = 1 + below(3); i > 0; --i) t.insert(at(close), inside.begin(), inside.end());
      t.insert(at(close), make(Token::Kind::Space, " "));
      break;
    }
    case 3:
      t.erase(at(below(2) ? open : close));
      break;
    case 4:
      t.insert(at(open), make(Token::Kind::Other, std::string(1 + below(kMostRepeats), '[')));
      break;
    case 5:
      t.insert(at(close), make(Token::Kind::Space, " " + (below(2) ? number() : string()) + " "));
      break;
    case 6:  // one value for all
      for (size_t i = open + 1; i < close; ++i)
        if (t[i].kind == Token::Kind::Number)
          t[i].text = t[open + 1].kind == Token::Kind::Number ? t[open + 1].text : "0";
      break;
    default:
      t.insert(at(open + 1), make(Token::Kind::Space, number() + " "));
  }
}

void RibMutator::mutateTokens(std::vector<Token>& t, const std::vector<Token>& other) {
  if (t.empty()) return;
  using enum Token::Kind;
  const auto pick = [&](Token::Kind kind) {
    const auto found = all(t, kind);
    return found.empty() ? t.size() : found[below(found.size())];
  };
  switch (below(8)) {
    case 0:
    case 1:
      if (const size_t i = pick(Number); i < t.size()) t[i].text = number();
      break;
    case 2:
      if (const size_t i = pick(String); i < t.size()) t[i].text = below(3) ? string() : value('P');
      break;
    case 3:
      if (const size_t i = pick(Word); i < t.size()) t[i].text = kRequests[below(std::size(kRequests))].name;
      break;
    case 4:
      t.erase(t.begin() + below(t.size()));
      break;
    case 5: {
      const size_t i = below(t.size());
      const Token copy = t[i];
      t.insert(t.begin() + ptrdiff_t(i), 1 + (below(5) ? 0 : below(kMostRepeats)), copy);
      break;
    }
    case 6:
      std::swap(t[below(t.size())], t[below(t.size())]);
      break;
    default:
      if (!other.empty()) t[below(t.size())] = other[below(other.size())];
  }
}

void RibMutator::mutateRequests(std::vector<Token>& t, const std::vector<Token>& other) {
  const auto starts = requestsOf(t);
  const size_t n = starts.size() - 1;
  const size_t a = below(n + 1), b = std::min(n, a + 1 + below(below(4) ? 3 : 40));
  const auto at = [&](size_t i) { return t.begin() + ptrdiff_t(starts[i]); };
  const auto space = [](std::string s) { return make(Token::Kind::Space, std::move(s)); };
  const std::vector<Token> piece(at(a), at(b));
  switch (below(8)) {
    case 0:
      t.erase(at(a), at(b));
      break;
    case 1:  // again, here or elsewhere
      for (size_t i = 1 + (below(6) ? 0 : below(40)); i > 0; --i) t.insert(at(b), piece.begin(), piece.end());
      break;
    case 2: {
      const size_t to = below(n + 1);
      t.insert(at(to), space("\n"));
      t.insert(t.begin() + ptrdiff_t(starts[to]) + 1, piece.begin(), piece.end());
      break;
    }
    case 3:
    case 4: {  // a piece of the other file
      const auto from = requestsOf(other);
      const size_t m = from.size() - 1, c = below(m + 1), d = std::min(m, c + 1 + below(10));
      const std::vector<Token> taken(other.begin() + ptrdiff_t(from[c]), other.begin() + ptrdiff_t(from[d]));
      t.insert(at(a), space("\n"));
      t.insert(t.begin() + ptrdiff_t(starts[a]), taken.begin(), taken.end());
      break;
    }
    case 5: {  // around a piece: a block
      const Bracket& k = kBrackets[below(std::size(kBrackets))];
      const size_t times = below(8) ? 1 : below(kMostRepeats);
      std::string begin, end;
      for (size_t i = 0; i < times; ++i)
        begin += std::string("\n") + k.begin + "\n", end += std::string("\n") + k.end + "\n";
      if (below(10)) t.insert(at(b), space(end));
      t.insert(at(a), space(begin));
      break;
    }
    case 6:
      t.insert(at(a), space(below(2) ? request() : "\n" + std::string(kPieces[below(std::size(kPieces))])));
      break;
    default:
      t.insert(at(a), space(request()));
  }
}

// The same values in the binary encodings of section 1 of the RIB reference.
void RibMutator::encode(std::vector<Token>& t) {
  if (t.empty()) return;
  size_t begin = below(t.size()), end = std::min(t.size(), begin + 1 + below(200));
  for (size_t i = begin; i < end; ++i) {
    std::string& s = t[i].text;
    if (t[i].kind == Token::Kind::Number) {
      const double v = std::strtod(s.c_str(), nullptr);
      switch (below(4)) {
        case 0:
          s = "\244" + bigEndian(std::bit_cast<uint32_t>(float(v)), 4);
          break;
        case 1:
          s = "\245" + bigEndian(std::bit_cast<uint64_t>(v), 8);
          break;
        default: {
          const int width = int(below(4)), point = int(below(4));
          const double scaled = std::abs(v) < 1e6 ? v * double(1 << (8 * point)) : 0;
          s = char(0200 + 4 * point + width) + bigEndian(uint64_t(int64_t(scaled)), width + 1);
        }
      }
    } else if (t[i].kind == Token::Kind::String && s.size() >= 2) {
      const std::string inside = s.substr(1, s.size() - 2);
      if (below(4) == 0) {  // a definition, then its use
        const char code = char(below(256));
        s = std::string("\315") + code + s + "\317" + code;
      } else if (inside.size() < 16 && below(2)) {
        s = char(0220 + inside.size()) + inside;
      } else {
        const int width = 1 + int(below(4));
        s = char(0237 + width) + bigEndian(inside.size(), width) + inside;
      }
    } else if (t[i].kind == Token::Kind::Word && below(3) == 0) {
      const char code = char(below(256));
      s = std::string("\314") + code + "\"" + s + "\"\246" + code;
    } else if (t[i].kind == Token::Kind::Open) {
      size_t close = i + 1, n = 0;
      std::string data;
      for (; close < t.size() && (t[close].kind == Token::Kind::Number || t[close].kind == Token::Kind::Space);
           ++close)
        if (t[close].kind == Token::Kind::Number)
          data += bigEndian(std::bit_cast<uint32_t>(float(std::strtod(t[close].text.c_str(), nullptr))), 4), ++n;
      if (close == t.size() || t[close].kind != Token::Kind::Close) continue;
      const int width = 1 + int(below(4));
      s = char(0307 + width) + bigEndian(below(20) ? n : below(1u << 31), width) + data;
      for (size_t k = i + 1; k <= close; ++k) t[k].text.clear();
      i = close;
    }
  }
}

void RibMutator::mutateBytes(std::string& s) {
  if (s.empty()) return;
  for (size_t i = 1 + below(4); i > 0; --i) {
    const size_t at = below(s.size());
    switch (below(4)) {
      case 0:
        s[at] ^= char(1 << below(8));
        break;
      case 1:
        s[at] = char(below(256));
        break;
      case 2:
        s.insert(at, 1 + below(4), char(below(256)));
        break;
      default:
        s.erase(at, 1 + below(8));
        if (s.empty()) return;
    }
  }
}

std::string RibMutator::mutateText(std::string text, const std::string& other, size_t limit) {
  if (below(10) == 0) {
    mutateBytes(text);
    return text;
  }
  if (below(40) == 0) return text.substr(0, below(text.size() + 1));
  std::vector<Token> t = tokensOf(text);
  const std::vector<Token> o = tokensOf(std::string_view(other).substr(0, limit));
  for (size_t i = 1 + below(3); i > 0; --i) switch (below(8)) {
      case 0:
        mutateArray(t);
        break;
      case 1:
        if (below(3) == 0) encode(t);
        [[fallthrough]];
      case 2:
      case 3:
        mutateTokens(t, o);
        break;
      default:
        mutateRequests(t, o);
    }
  return textOf(t);
}

std::string RibMutator::mutate(const std::string& input, const std::string& other, size_t limit) {
  RibInput in = splitInput(input);
  std::string from = other, plain;
  if (other.starts_with("\x1f\x8b") && gunzipped(other, plain, limit)) from = plain;
  // which of its files; a compressed one is opened, changed and closed again, or broken as it is
  const size_t which = below(in.files.size() + 2);
  std::string& target = which < in.files.size() ? in.files[which].second : in.main;
  const bool isGzip = target.starts_with("\x1f\x8b");
  if (isGzip && below(4) == 0) {
    mutateBytes(target);
  } else if (isGzip) {
    if (gunzipped(target, plain, limit * 4)) {
      plain = mutateText(std::move(plain), from, limit);
      target = below(6) ? gzipped(plain) : plain;
    }
  } else if (target.starts_with("PK")) {
    mutateBytes(target);
  } else if (below(30) == 0) {
    target = gzipped(target);
  } else if (below(30) == 0 && in.files.size() < 4) {  // a piece of it into an archive of its own
    const size_t a = below(target.size() + 1), b = a + below(target.size() - a + 1);
    const std::string piece = target.substr(a, b - a), name = std::string("f") + char('a' + below(6));
    // the target first: a new file moves the others
    switch (below(4)) {
      case 0:
        target.replace(a, b - a, "\nReadArchive \"" + name + ".zip!m.rib\"\n");
        in.files.emplace_back(name + ".zip", zipped("m.rib", piece, below(2)));
        break;
      case 1:
        target.replace(a, b - a,
                       "\nArchiveBegin \"" + name + "\"\n" + piece + "\nArchiveEnd\nReadArchive \"" + name + "\"\n");
        break;
      default:
        target.replace(a, b - a,
                       below(2) ? "\nReadArchive \"" + name + "\"\n"
                                : "\nProcedural \"DelayedReadArchive\" [\"" + name + "\"] [-1 1 -1 1 -1 1]\n");
        in.files.emplace_back(name, below(3) ? piece : gzipped(piece));
    }
  } else {
    target = mutateText(std::move(target), from, limit);
  }
  std::string out = joinInput(in);
  if (out.size() > limit) out.resize(limit);
  return out;
}

}  // namespace kinora::fuzz
