// SPDX-License-Identifier: MIT
#include "likelihood/shared_clusters.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include "silvafit/base/ranks.hpp"

namespace silvafit::fit {

VectorXd sum_over_ranks(const std::vector<VectorXd>& own, Index size) {
  const auto count = static_cast<std::size_t>(size);
  std::string bytes;
  for (const VectorXd& block : own) append_numbers(block.data(), count, bytes);
  VectorXd sum = VectorXd::Zero(size);
  for (const std::string& of_rank : Ranks::of_process().gather(bytes)) {
    std::string_view rest = of_rank;
    while (!rest.empty()) {
      const std::vector<double> block = take_numbers(rest);
      sum += Eigen::Map<const VectorXd>(block.data(), size);
    }
  }
  return sum;
}

bool is_on_any_rank(bool is_here) {
  const std::vector<std::string> all = Ranks::of_process().gather(is_here ? "1" : "0");
  return std::ranges::find(all, "1") != all.end();
}

}  // namespace silvafit::fit
