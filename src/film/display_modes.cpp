#include "film/display_modes.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "base/text.h"

namespace kinora::film {
namespace {

bool isBlank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

// Cut where `isSeparator` says, but not inside the brackets and quotes of a light path expression.
template <class IsSeparator>
std::vector<std::string> split(const std::string& text, IsSeparator isSeparator) {
  std::vector<std::string> parts(1);
  int depth = 0;
  char quote = '\0';
  for (const char c : text) {
    if (quote != '\0')
      quote = c == quote ? '\0' : quote;
    else if (c == '\'' || c == '"')
      quote = c;
    else if (c == '(' || c == '[' || c == '{' || c == '<')
      ++depth;
    else if (c == ')' || c == ']' || c == '}' || c == '>')
      depth = std::max(0, depth - 1);
    if (depth == 0 && quote == '\0' && isSeparator(c))
      parts.emplace_back();
    else
      parts.back() += c;
  }
  std::erase(parts, "");
  return parts;
}

// "{Ci,a}", "[rgba]"
std::string withoutBrackets(std::string text) {
  const auto trim = [&] {
    while (!text.empty() && isBlank(text.back())) text.pop_back();
    while (!text.empty() && isBlank(text.front())) text.erase(0, 1);
  };
  trim();
  while (text.size() >= 2) {
    const char a = text.front(), b = text.back();
    const bool isPair = (a == '{' && b == '}') || (a == '[' && b == ']') || (a == '(' && b == ')') ||
                        ((a == '"' || a == '\'') && a == b);
    if (!isPair) break;
    text = text.substr(1, text.size() - 2);
    trim();
  }
  return text;
}

// "color" or "float[3]"; false for what is no type of a channel.
bool readType(const std::string& word, ModeChannel& out) {
  static constexpr std::pair<const char*, scene::ValueType> kTypes[] = {
      {"float", scene::ValueType::Float},   {"int", scene::ValueType::Int},      {"integer", scene::ValueType::Int},
      {"color", scene::ValueType::Color},   {"point", scene::ValueType::Point},  {"vector", scene::ValueType::Vector},
      {"normal", scene::ValueType::Normal}, {"hpoint", scene::ValueType::HPoint}};
  const size_t bracket = word.find('[');
  const std::string name = word.substr(0, bracket);
  const auto known = std::find_if(std::begin(kTypes), std::end(kTypes), [&](auto& t) { return name == t.first; });
  if (known == std::end(kTypes)) return false;
  out.type = known->second;
  if (bracket == std::string::npos) return true;
  int n = 0;
  size_t at = bracket + 1;
  for (; at < word.size() && std::isdigit(static_cast<unsigned char>(word[at])) && n < 1000; ++at)
    n = 10 * n + (word[at] - '0');
  out.arrayLength = n;
  return n > 0 && at + 1 == word.size() && word[at] == ']';
}

bool isStorage(const std::string& word) {
  for (const char* s : {"constant", "uniform", "varying", "vertex", "facevarying"})
    if (word == s) return true;
  return false;
}

// The channels of a word that is one of RIB's modes: rgb with any of a, z and o (opacity), a, z, az. Empty for
// others.
std::vector<const char*> channelsOfWord(const std::string& word) {
  std::string rest = lowerCase(word);
  std::vector<const char*> list;
  const size_t colour = rest.find("rgb");
  if (colour != std::string::npos) {
    rest.erase(colour, 3);
    list.push_back("Ci");
  }
  const bool hasColour = !list.empty();
  for (const char c : rest) {
    const char* name = c == 'a' ? "a" : c == 'z' ? "z" : c == 'o' && hasColour ? "Oi" : nullptr;
    if (!name || std::count(rest.begin(), rest.end(), c) > 1) return {};
    list.push_back(name);
  }
  return list;
}

}  // namespace

std::vector<ModeChannel> channelsOfMode(const scene::Scene& scene, const scene::Display& display) {
  std::vector<ModeChannel> list;
  const auto add = [&](ModeChannel c) {
    if (std::none_of(list.begin(), list.end(), [&](const ModeChannel& k) { return k.name == c.name; }))
      list.push_back(std::move(c));
  };
  const auto isDeclared = [&](const std::string& name) {
    return std::any_of(scene.channels.begin(), scene.channels.end(), [&](auto& d) { return d.name == name; });
  };
  std::vector<std::vector<std::string>> items;
  for (const std::string& item : split(withoutBrackets(display.mode), [](char c) { return c == ',' || c == ';'; }))
    items.push_back(split(item, isBlank));
  // "r,g,b,a": the letters of a colour
  const auto isListed = [&](char letter) {
    return std::any_of(items.begin(), items.end(), [&](const auto& words) {
      return std::any_of(words.begin(), words.end(), [&](const std::string& w) {
        return lowerCase(w) == std::string(1, letter) && !isDeclared(w);
      });
    });
  };
  const bool hasLetters = isListed('r') && isListed('g') && isListed('b');
  for (const auto& words : items) {
    ModeChannel typed;
    const size_t at = words.size() > 2 && isStorage(words[0]) ? 1 : 0;
    if (words.size() == at + 2 && readType(words[at], typed)) {
      typed.name = words[at + 1];
      add(std::move(typed));
      continue;
    }
    for (const std::string& word : words) {
      const std::string lower = lowerCase(word);
      if (isDeclared(word)) {
        add({word, {}, 1});
      } else if (hasLetters && (lower == "r" || lower == "g" || lower == "b")) {
        add({"Ci", {}, 1});
      } else if (const auto channels = channelsOfWord(word); !channels.empty()) {
        for (const char* name : channels) add({name, {}, 1});
      } else {
        add({word, {}, 1});
      }
    }
  }
  if (list.empty()) list = {{"Ci", {}, 1}, {"a", {}, 1}};
  return list;
}

}  // namespace kinora::film
