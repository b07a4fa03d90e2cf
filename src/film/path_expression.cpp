#include "film/path_expression.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace kinora::film {
namespace {

constexpr int kMostRepeats = 64, kMostDepth = 64;
constexpr size_t kMostText = 4096;

struct Failure {
  size_t column;
  std::string what;
};

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  PathExpression run() {
    if (text_.size() > kMostText)
      fail(0, "the expression is longer than " + std::to_string(kMostText) + " characters");
    readFlags();
    if (atEnd()) fail(at_, "there is no expression");
    std::vector<int> choices{sequence()};
    while (head() == '|') {
      ++at_;
      choices.push_back(sequence());
    }
    if (!atEnd())
      fail(at_, head() == ')' ? "\")\" closes nothing" : std::string("\"") + text_[at_] + "\" is not expected here");
    // Only the first alternative has to say C: "C(D[DS]*L)|[LO]" is written for "C(D[DS]*L|[LO])".
    for (size_t i = 0; i < choices.size(); ++i) {
      if (beginsAtCamera(choices[i])) continue;
      if (i == 0) fail(e_.nodes[size_t(choices[0])].column, "a light path begins with C, the camera");
      const size_t column = e_.nodes[size_t(choices[i])].column;
      PathPattern camera;
      camera.kind = PathEventKind::Camera;
      const int c = leaf({{camera}, false}, column);
      choices[i] = inner(PathNode::Kind::Sequence, {c, choices[i]}, column);
    }
    for (const int c : choices) checkCameras(c, true);
    e_.root = choices.size() == 1 ? choices[0] : inner(PathNode::Kind::Choice, choices, 0);
    return std::move(e_);
  }

 private:
  [[noreturn]] void fail(size_t column, std::string what) const { throw Failure{column, std::move(what)}; }
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  bool atEnd() {
    skip();
    return at_ >= text_.size();
  }
  char head() { return atEnd() ? '\0' : text_[at_]; }
  char take() {
    const char c = head();
    at_ += c != '\0';
    return c;
  }
  int leaf(PathAtom atom, size_t column) {
    e_.atoms.push_back(std::move(atom));
    PathNode n;
    n.kind = PathNode::Kind::Atom;
    n.atom = int(e_.atoms.size()) - 1;
    n.column = column;
    e_.nodes.push_back(std::move(n));
    return int(e_.nodes.size()) - 1;
  }
  int inner(PathNode::Kind kind, std::vector<int> children, size_t column) {
    PathNode n;
    n.kind = kind;
    n.children = std::move(children);
    n.column = column;
    e_.nodes.push_back(std::move(n));
    return int(e_.nodes.size()) - 1;
  }

  void readFlags() {
    static constexpr std::pair<const char*, bool PathFlags::*> kNames[] = {
        {"shadows", &PathFlags::shadows},
        {"holdouts", &PathFlags::holdouts},
        {"unoccluded", &PathFlags::unoccluded},
        {"nothruput", &PathFlags::noThroughput},
        {"noinfinitecheck", &PathFlags::noInfiniteCheck},
        {"noclamp", &PathFlags::noClamp},
        {"overwrite", &PathFlags::overwrite}};
    for (;;) {
      skip();
      size_t end = at_;
      while (end < text_.size() && std::islower(static_cast<unsigned char>(text_[end]))) ++end;
      if (end == at_ || end >= text_.size() || text_[end] != ';') return;
      const std::string_view word = text_.substr(at_, end - at_);
      const auto known = std::find_if(std::begin(kNames), std::end(kNames), [&](auto& n) { return word == n.first; });
      if (known == std::end(kNames)) fail(at_, "there is no prefix \"" + std::string(word) + ";\"");
      e_.flags.*known->second = true;
      at_ = end + 1;
    }
  }

  int sequence() {
    const size_t column = (skip(), at_);
    std::vector<int> parts;
    for (char c = head(); c != '\0' && c != '|' && c != ')'; c = head()) parts.push_back(repeated());
    if (parts.empty()) fail(column, "an event is missing here");
    return parts.size() == 1 ? parts[0] : inner(PathNode::Kind::Sequence, std::move(parts), column);
  }

  int repeated() {
    const size_t column = at_;
    int node = single();
    for (;;) {
      int least, most;
      switch (head()) {
        case '*':
          least = 0, most = -1;
          break;
        case '+':
          least = 1, most = -1;
          break;
        case '?':
          least = 0, most = 1;
          break;
        case '{': {
          const size_t open = at_++;
          least = number("how often");
          most = least;
          if (head() == ',') {
            ++at_;
            most = head() == '}' ? -1 : number("how often at most");
          }
          if (take() != '}') fail(open, "\"{\" is not closed");
          if (most >= 0 && most < least) fail(open, "the repetition ends before it begins");
          --at_;
          break;
        }
        default:
          return node;
      }
      ++at_;
      node = inner(PathNode::Kind::Repeat, {node}, column);
      e_.nodes[size_t(node)].least = least;
      e_.nodes[size_t(node)].most = most;
    }
  }

  int number(const char* what) {
    skip();
    const size_t column = at_;
    int n = 0;
    while (at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_])) && n <= kMostRepeats)
      n = 10 * n + (text_[at_++] - '0');
    if (at_ == column) fail(column, std::string("a number is missing: ") + what);
    if (n > kMostRepeats) fail(column, "at most " + std::to_string(kMostRepeats) + " repetitions can be asked for");
    return n;
  }

  int single() {
    skip();
    const size_t column = at_;
    if (head() == '(') {
      if (++depth_ > kMostDepth) fail(column, "the brackets are too deep");
      ++at_;
      std::vector<int> choices{sequence()};
      while (head() == '|') {
        ++at_;
        choices.push_back(sequence());
      }
      if (take() != ')') fail(column, "\"(\" is not closed");
      --depth_;
      return choices.size() == 1 ? choices[0] : inner(PathNode::Kind::Choice, std::move(choices), column);
    }
    if (head() == '[') return set();
    PathAtom atom;
    std::vector<PathAtom> others;
    event(atom.patterns, others);
    return leaf(others.empty() ? std::move(atom) : std::move(others[0]), column);
  }

  int set() {
    const size_t open = at_++;
    PathAtom atom;
    if (head() == '^') {
      atom.isNegated = true;
      ++at_;
    }
    std::vector<PathAtom> others;
    while (head() != ']') {
      if (atEnd()) fail(open, "\"[\" is not closed");
      const size_t column = at_, before = others.size();
      event(atom.patterns, others);
      if (others.size() > before) {
        if (atom.isNegated) fail(column, "an event without some labels cannot stand in a set of what is left out");
      } else if (atom.patterns.back().kind == PathEventKind::Camera) {
        fail(column, "C cannot stand in a set");
      }
    }
    ++at_;
    if (atom.patterns.empty() && others.empty()) fail(open, "the set is empty");
    std::vector<int> choices;
    if (!atom.patterns.empty()) choices.push_back(leaf(std::move(atom), open));
    for (PathAtom& o : others) choices.push_back(leaf(std::move(o), open));
    return choices.size() == 1 ? choices[0] : inner(PathNode::Kind::Choice, std::move(choices), open);
  }

  // The events of `p` with none of the labels, as the complement of all others and of those with one of them.
  PathAtom without(const PathPattern& p, const std::vector<std::string>& labels, size_t column) const {
    if (p.kind == PathEventKind::Scatter && (p.lobes & kUserLobes))
      fail(column, "labels cannot be left out of signals (U)");
    PathAtom atom;
    atom.isNegated = true;
    for (const PathEventKind kind : {PathEventKind::Scatter, PathEventKind::Light, PathEventKind::Object}) {
      PathPattern other;
      other.kind = kind;
      if (kind != p.kind) atom.patterns.push_back(other);
    }
    if (p.kind == PathEventKind::Scatter) {
      PathPattern other;
      other.types = uint8_t(kPathAnyType & ~p.types);
      if (other.types) atom.patterns.push_back(other);
      other.types = kPathAnyType;
      other.lobes = (kDiffuseLobes | kSpecularLobes) & ~p.lobes;
      if (other.lobes) atom.patterns.push_back(other);
    }
    for (const std::string& l : labels) {
      atom.patterns.push_back(p);
      atom.patterns.back().label = l;
    }
    return atom;
  }

  // One event outside of sets and groups; appends its patterns, or to `others` what leaves labels out.
  void event(std::vector<PathPattern>& out, std::vector<PathAtom>& others) {
    skip();
    const size_t column = at_;
    PathPattern p;
    switch (const char c = take()) {
      case '\0':
        fail(column, "an event is missing here");
      case 'C':
        p.kind = PathEventKind::Camera;
        break;
      case 'L':
        p.kind = PathEventKind::Light;
        break;
      case 'O':
        p.kind = PathEventKind::Object;
        break;
      case 'R':
        p.types = kPathReflect;
        break;
      case 'T':
        p.types = kPathTransmit;
        break;
      case 'V':
        p.types = kPathVolume;
        break;
      case 'D':
      case 'S':
      case 'U':
        p.lobes = lobes(c);
        break;
      case '.':
        out.push_back(p);
        p.kind = PathEventKind::Light;
        out.push_back(p);
        p.kind = PathEventKind::Object;
        break;
      case '<': {
        const Labels labels = group(column, p);
        if (labels.areLeftOut) {
          others.push_back(without(p, labels.names, column));
          return;
        }
        for (size_t i = 1; i < labels.names.size(); ++i) {
          out.push_back(p);
          out.back().label = labels.names[i];
        }
        if (!labels.names.empty()) p.label = labels.names[0];
        break;
      }
      default:
        fail(column, std::string("\"") + c + "\" is no event: C, L, O, D, S, U, R, T, V, \".\" or <...> are");
    }
    out.push_back(std::move(p));
  }

  // The lobes of D, S or U with the number that may follow.
  uint32_t lobes(char letter) {
    const int first = letter == 'D' ? 0 : letter == 'S' ? kFirstSpecularLobe : kFirstUserLobe;
    const int count = letter == 'D' ? 4 : letter == 'S' ? 8 : 12;
    const size_t column = at_;
    int n = 0;
    while (at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_])) && n < 100)
      n = 10 * n + (text_[at_++] - '0');
    if (at_ == column) return ((1u << count) - 1) << first;
    if (n < 1 || n > count)
      fail(column, std::string("lobes ") + letter + " are numbered 1 to " + std::to_string(count));
    return 1u << (first + n - 1);
  }

  // One place of <...>: "X", "[XY]", "[^XY]" or ".". `one` turns a letter into bits, 0 when it does not belong there.
  template <class One>
  uint32_t place(uint32_t any, uint32_t all, One one, const char* what) {
    const size_t column = (skip(), at_);
    const char c = take();
    if (c == '.') return any;
    const auto read = [&](char letter, size_t where) {
      const uint32_t bits = one(letter);
      if (!bits) fail(where, std::string("here stands ") + what);
      return bits;
    };
    if (c != '[') return read(c, column);
    const bool isNegated = head() == '^';
    at_ += isNegated;
    uint32_t bits = 0;
    while (head() != ']') {
      if (atEnd()) fail(column, "\"[\" is not closed");
      const size_t where = at_;
      bits |= read(take(), where);
    }
    ++at_;
    if (!bits) fail(column, "the set is empty");
    return isNegated ? all & ~bits : bits;
  }

  struct Labels {
    std::vector<std::string> names;
    bool areLeftOut = false;
  };

  // The last place of <...>: 'a', ['a' 'b'], [^'a' 'b'], "." or nothing.
  Labels labels() {
    Labels l;
    if (head() == '.') {
      ++at_;
      return l;
    }
    const bool isSet = head() == '[';
    const size_t open = at_;
    if (isSet) {
      ++at_;
      l.areLeftOut = head() == '^';
      at_ += l.areLeftOut;
    }
    for (char quote = head(); quote == '\'' || quote == '"'; quote = isSet ? head() : '\0') {
      const size_t column = at_++;
      const size_t end = text_.find(quote, at_);
      if (end == std::string_view::npos) fail(column, "the label's quotation mark is not closed");
      l.names.emplace_back(text_.substr(at_, end - at_));
      at_ = end + 1;
      if (l.names.back().empty()) fail(column, "the label is empty");
    }
    if (!isSet) return l;
    if (atEnd()) fail(open, "\"[\" is not closed");
    if (take() != ']') fail(at_ - 1, "a label in quotation marks, or \"]\", is expected here");
    if (l.names.empty()) fail(open, "the set is empty");
    return l;
  }

  // What stands behind "<": the event goes to `p`, without its labels.
  Labels group(size_t open, PathPattern& p) {
    const char c = head();
    if (c == 'L' || c == 'O' || c == 'C') {
      ++at_;
      p.kind = c == 'L' ? PathEventKind::Light : c == 'O' ? PathEventKind::Object : PathEventKind::Camera;
      if (head() == '.') ++at_;
    } else {
      p.types = uint8_t(place(
          kPathAnyType, kPathAnyType,
          [](char t) {
            return uint32_t(t == 'R' ? kPathReflect : t == 'T' ? kPathTransmit : t == 'V' ? kPathVolume : 0);
          },
          "the type of the event: R, T, V, a set of them, or \".\""));
      if (head() != '>' && head() != '\'' && head() != '"')
        p.lobes = place(
            kDiffuseLobes | kSpecularLobes, kDiffuseLobes | kSpecularLobes,
            [&](char e) { return e == 'D' || e == 'S' || e == 'U' ? lobes(e) : 0u; },
            "the event: D, S, U, one of their lobes (D2), a set of them, or \".\"");
    }
    const size_t column = at_;
    Labels l = labels();
    if (!l.names.empty() && p.kind == PathEventKind::Camera) fail(column, "C takes no label; lights and surfaces do");
    if (atEnd()) fail(open, "\"<\" is not closed");
    if (take() != '>') fail(at_ - 1, "\">\" is expected here");
    return l;
  }

  bool isNullable(int n) const {
    const PathNode& node = e_.nodes[size_t(n)];
    switch (node.kind) {
      case PathNode::Kind::Atom:
        return false;
      case PathNode::Kind::Repeat:
        return node.least == 0 || isNullable(node.children[0]);
      case PathNode::Kind::Choice:
        return std::any_of(node.children.begin(), node.children.end(), [&](int c) { return isNullable(c); });
      case PathNode::Kind::Sequence:
        return std::all_of(node.children.begin(), node.children.end(), [&](int c) { return isNullable(c); });
    }
    return false;
  }
  bool isCamera(const PathNode& node) const {
    return node.kind == PathNode::Kind::Atom && e_.atoms[size_t(node.atom)].patterns[0].kind == PathEventKind::Camera;
  }
  bool beginsAtCamera(int n) const {
    const PathNode& node = e_.nodes[size_t(n)];
    if (node.kind == PathNode::Kind::Atom) return isCamera(node);
    if (node.kind == PathNode::Kind::Choice)
      return std::any_of(node.children.begin(), node.children.end(), [&](int c) { return beginsAtCamera(c); });
    return beginsAtCamera(node.children[0]);
  }
  // C anywhere but at the beginning matches nothing; that is a mistake worth a word.
  void checkCameras(int n, bool isFirst) const {
    const PathNode& node = e_.nodes[size_t(n)];
    if (isCamera(node) && !isFirst) fail(node.column, "C stands at the beginning only");
    for (const int c : node.children) {
      checkCameras(c, isFirst);
      if (node.kind == PathNode::Kind::Sequence && !isNullable(c)) isFirst = false;
    }
  }

  std::string_view text_;
  size_t at_ = 0;
  int depth_ = 0;
  PathExpression e_;
};

}  // namespace

std::optional<PathExpression> parsePathExpression(std::string_view text, PathSyntaxError& error) {
  try {
    return Parser(text).run();
  } catch (const Failure& f) {
    error = {f.column, f.what};
    return std::nullopt;
  }
}

std::string caretBelow(std::string_view text, size_t column) {
  constexpr size_t kSide = 60;
  column = std::min(column, text.size());
  const size_t begin = column > kSide ? column - kSide : 0;
  const size_t end = std::min(text.size(), column + kSide);
  std::string shown(text.substr(begin, end - begin));
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 32) c = ' ';
  if (end < text.size()) shown += "...";
  const std::string before = begin > 0 ? "..." : "";
  return "\x1e    " + before + shown + "\x1e    " + std::string(before.size() + column - begin, ' ') + "^";
}

}  // namespace kinora::film
