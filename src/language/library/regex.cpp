#include "language/library/regex.h"

#include <cmath>
#include <memory>
#include <mutex>
#include <regex>
#include <unordered_map>

namespace kinora::language {
namespace {
struct Compiled {
  std::regex backtracking, breadthFirst;
  bool backReferences = false, repeatsGroups = false;
  int quantifiers = 0;
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
    } else if (p[i] == ')') {
      c.repeatsGroups |= quantifies(i + 1);
    }
  }
}
// Backtracking tries at most about length^(quantifiers + 1) ways, and 2^length and more where groups are repeated.
bool mayBacktrack(const Compiled& c, size_t length) {
  constexpr double kMostSteps = 1e7;
  const double n = double(length) + 1;
  return c.repeatsGroups ? length <= 16 : std::pow(n, c.quantifiers + 1) <= kMostSteps && length <= 4096;
}
std::shared_ptr<const Compiled> compile(std::string_view pattern) {
  auto c = std::make_shared<Compiled>();
  if (pattern.size() > kLongestRegexPattern) {
    c->reason = "the regular expression is longer than " + std::to_string(kLongestRegexPattern) + " characters";
    return c;
  }
  survey(pattern, *c);
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
  const bool backtrack = (c->backReferences || count > 0) && mayBacktrack(*c, subject.size());
  if (subject.size() > kLongestRegexSubject || (c->backReferences && !backtrack)) {
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
