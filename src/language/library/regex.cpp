#include "language/library/regex.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <regex>
#include <unordered_map>
#include <vector>

namespace kinora::language {
namespace {
struct Compiled {
  std::regex backtracking, breadthFirst;
  bool backReferences = false, repeatsGroups = false;
  int quantifiers = 0, bars = 0;
  double size = 0;     // in characters, repetitions written out
  std::string reason;  // why it cannot be used
};
// What the pattern holds, read without classes and escapes: too many counted is safe, too few is not.
void survey(std::string_view p, Compiled& c) {
  for (size_t i = 0; i < p.size(); ++i) {
    const auto quantifies = [&](size_t at) { return at < p.size() && std::string_view("*+{").find(p[at]) < 3; };
    if (p[i] == '\\') {
      ++i;
      c.backReferences |= i < p.size() && p[i] >= '1' && p[i] <= '9';
    } else if (quantifies(i) || p[i] == '?') {
      ++c.quantifiers;
    } else if (p[i] == '|') {
      ++c.bars;
    } else if (p[i] == ')') {
      c.repeatsGroups |= quantifies(i + 1);
    }
  }
}
// The size of the automaton: what {n,m} repeats counts as often. The standard library's stack grows with it and its
// time with size times length.
double expandedSize(std::string_view p) {
  std::vector<double> open{0};
  double last = 0;
  const auto add = [&](double atom) { last = atom, open.back() += atom; };
  for (size_t i = 0; i < p.size(); ++i) {
    if (p[i] == '\\') {
      ++i, add(1);
    } else if (p[i] == '[') {
      while (i + 1 < p.size() && p[i] != ']') i += p[i] == '\\' ? 2 : 1;
      add(1);
    } else if (p[i] == '(') {
      open.push_back(0);
    } else if (p[i] == ')' && open.size() > 1) {
      const double group = open.back() + 1;
      open.pop_back();
      add(group);
    } else if (p[i] == '{') {
      double most = 1, number = 0;
      for (++i; i < p.size() && p[i] != '}'; ++i) {
        number = p[i] >= '0' && p[i] <= '9' ? number * 10 + (p[i] - '0') : 0;
        most = std::max(most, number);
      }
      open.back() += last * (most - 1);
      last *= most;
    } else {
      add(1);
    }
  }
  double all = 0;
  for (double s : open) all += s;
  return all;
}
constexpr double kLargestRegex = 4000, kMostWork = 2e7;  // about a fifth of a second
// How many ways backtracking may try: a quantifier ends at any of `length` places, an alternative doubles; a repeated
// group chooses anew at every character, and two repetitions of which one holds the other are beyond counting.
bool mayBacktrack(const Compiled& c, size_t length) {
  constexpr double kMostSteps = 1e7;
  const double n = double(length) + 1;
  if (c.quantifiers > 0 && length > 1024) return false;  // the stack's depth
  if (!c.repeatsGroups) return std::pow(n, c.quantifiers + 1) * std::exp2(c.bars) <= kMostSteps;
  return c.quantifiers == 1 && n * std::pow(c.bars + 1, double(length)) <= kMostSteps;
}
std::shared_ptr<const Compiled> compile(std::string_view pattern) {
  auto c = std::make_shared<Compiled>();
  if (pattern.size() > kLongestRegexPattern) {
    c->reason = "the regular expression is longer than " + std::to_string(kLongestRegexPattern) + " characters";
    return c;
  }
  survey(pattern, *c);
  c->size = expandedSize(pattern);
  if (!(c->size <= kLargestRegex)) {
    c->reason = "the regular expression is too large with its repetitions written out";
    return c;
  }
  try {
    c->backtracking.assign(pattern.begin(), pattern.end(), std::regex::ECMAScript);
    if (!c->backReferences)
      c->breadthFirst.assign(pattern.begin(), pattern.end(),
                             std::regex::ECMAScript | std::regex_constants::__polynomial);
  } catch (const std::exception& e) {
    c->reason = std::string("not a regular expression: ") + e.what();
  }
  return c;
}
std::shared_ptr<const Compiled> find(std::string_view pattern) {
  static std::mutex mutex;
  static std::unordered_map<std::string, std::shared_ptr<const Compiled>> cache;
  {
    const std::lock_guard lock(mutex);
    if (const auto it = cache.find(std::string(pattern)); it != cache.end()) return it->second;
  }
  auto c = compile(pattern);
  const std::lock_guard lock(mutex);
  if (cache.size() >= 1024) cache.clear();  // patterns made by a program while it runs; users hold what they use
  return cache.emplace(pattern, c).first->second;
}
}  // namespace

bool matchRegex(std::string_view subject, std::string_view pattern, bool whole, int32_t* results, int count,
                std::string& reason) {
  reason.clear();
  for (int i = 0; i < count; ++i) results[i] = int32_t(pattern.size());
  const auto c = find(pattern);
  if (!c->reason.empty()) {
    reason = c->reason;
    return false;
  }
  const bool backtrack = mayBacktrack(*c, subject.size());
  // a search starts anew at every character
  const double n = double(subject.size()), work = c->size * n * (whole ? 1 : n);
  if (subject.size() > kLongestRegexSubject || (c->backReferences && !backtrack) ||
      (!backtrack && work > kMostWork)) {
    reason = "a text of " + std::to_string(subject.size()) + " characters is too long for this regular expression";
    return false;
  }
  try {
    const char *const begin = subject.data(), *const end = begin + subject.size();
    const std::regex& regex = backtrack ? c->backtracking : c->breadthFirst;
    std::cmatch m;
    if (!(whole ? std::regex_match(begin, end, m, regex) : std::regex_search(begin, end, m, regex))) return false;
    for (int i = 0; i < count && size_t(i) / 2 < m.size(); ++i) {
      const std::csub_match& group = m[size_t(i) / 2];
      results[i] = int32_t((i % 2 ? group.second : group.first) - begin);
    }
    return true;
  } catch (const std::exception& e) {
    reason = std::string("the regular expression failed: ") + e.what();
    return false;
  }
}

}  // namespace kinora::language
