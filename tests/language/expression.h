// Formulas in which programs say what they expect: `sin(3 * u) + P.x`. Read and computed in double by a few lines
// that know nothing of the shading language's implementation. Values are lists of 1, 3 or more numbers; an operation
// between a number and a list goes component by component.
#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kinora::oracle {

using Numbers = std::vector<double>;
using Variables = std::map<std::string, Numbers, std::less<>>;

// Operators as in C without bits and assignments: ?: || && == != < <= > >= + - * / % ! and calls; (a, b, c) is a
// triple and {a, b, ...} a list, x.y a component (x y z or r g b), a[i] an element. Throws std::runtime_error for
// anything else.
Numbers evaluate(std::string_view formula, const Variables& variables);

}  // namespace kinora::oracle
