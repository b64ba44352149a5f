// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "silvafit/base/parallel.hpp"
#include "study/level_fits.hpp"
#include "study/nested_tests.hpp"
#include "study/plots_left_out.hpp"
#include "study/study_levels.hpp"
#include "study/study_work.hpp"

namespace silvafit::study {
namespace {

/// Examines the curves of a level's candidates.
Examination curves_of(const Work& work, const std::vector<Candidate>& candidates) {
  return
      [&work, &candidates](std::size_t i) { return work.objection_to_curves(candidates[i].fit); };
}

/// Examines mixed models: no less likely than what they contain, no farther from the observations
/// than least squares, and with plausible curves.
Examination mixed_models_of(const Work& work,
                            const std::vector<Candidate>& candidates,
                            std::vector<SmallerModel> smaller) {
  return [&work, &candidates, smaller = std::move(smaller)](std::size_t i) {
    const fit::FittedModel& fit = candidates[i].fit;
    std::string objection = objection_to_likelihood(fit, smaller);
    if (objection.empty() && work.compared) objection = objection_to_error(fit, *work.compared);
    return objection.empty() ? work.objection_to_curves(fit) : objection;
  };
}

/// Models that random effects may contain: without random effects, and with fewer of them.
std::vector<SmallerModel> smaller_random_effects(const Work& work) {
  std::vector<SmallerModel> smaller;
  if (work.compared) smaller.push_back({.name = "without random effects", .fit = &*work.compared});
  for (const Candidate& candidate : work.result.random) {
    smaller.push_back(
        {.name = fmt::format("with random effects on {}", fmt::join(candidate.terms, ", ")),
         .fit = &candidate.fit});
  }
  return smaller;
}

/// Models that a variance function may contain: a constant variance, and simpler functions.
std::vector<SmallerModel> smaller_variances(const ResponseStudy& result) {
  std::vector<SmallerModel> smaller;
  for (const Candidate& candidate : result.variance) {
    smaller.push_back(
        {.name = "with the variance function " + candidate.fit.specification.variance.text(),
         .fit = &candidate.fit});
  }
  return smaller;
}

/// The choice among the candidates of a level for one work.
struct Choice {
  std::size_t work = 0;
  std::vector<Candidate>* candidates = nullptr;
  std::function<std::optional<std::size_t>()> choose{};
  /// First candidate of the level; those before it are of an earlier level and have a final fit.
  std::size_t begin = 0;
  std::optional<std::size_t> chosen{};  ///< nothing if all final fits have objections
  /// Of the chosen candidate to all trees, unless it is of an earlier level.
  std::optional<fit::FitResult> final{};
};

/// The objection to the final fit of a chosen candidate: to all trees if a sample was compared, or
/// from all starts if one start was used.
std::string objection_to_final_fit(const Work& work, const fit::FittedModel& fit) {
  if (!fit.convergence.converged()) {
    return (work.is_sampled() ? "With all trees: " : "From all starts: ") +
           fit.convergence.verdict();
  }
  return work.objection_to_curves(fit);
}

/// Uses a fit unless there is an objection, which is returned.
std::string take_if_sound(const Work& work,
                          fit::FitResult fit,
                          std::optional<fit::FitResult>& target) {
  if (work.is_sampled()) {
    std::string objection = objection_to_final_fit(work, fit.fit);
    if (!objection.empty()) return objection;
  }
  target = std::move(fit);
  return "";
}

/// Judges the final fit of a choice.
/// \return  whether it is used
bool accept(const Work& work, fit::FitResult final, Choice& choice) {
  Candidate& candidate = (*choice.candidates)[*choice.chosen];
  // Candidates with an objection are chosen only if there is no other.
  const bool is_last_resort = !candidate.objection.empty();
  if (!is_last_resort) {
    candidate.objection = objection_to_final_fit(work, final.fit);
    if (!work.is_sampled()) candidate.fit = final.fit;
    if (!candidate.objection.empty()) return false;
  }
  choice.final = std::move(final);
  return true;
}

/// Chooses until the final fits of all choices have no objection. Threads, and the processes of a
/// job, share the fits of a round.
void settle(const std::vector<Work>& works,
            const LevelFits& level,
            unsigned threads,
            std::vector<Choice>& choices) {
  std::vector<Choice*> open;
  for (Choice& choice : choices) open.push_back(&choice);
  while (true) {
    parallel_for(open.size(), threads, [&](std::size_t i) { open[i]->chosen = open[i]->choose(); });
    std::erase_if(open, [](const Choice* choice) {
      return !choice->chosen || *choice->chosen < choice->begin;
    });
    if (open.empty()) return;
    std::vector<LevelFits::Place> places;
    for (const Choice* choice : open) {
      places.push_back({.work = choice->work, .position = *choice->chosen - choice->begin});
    }
    std::vector<fit::FitResult> finals = level.results(places, threads);
    std::vector<char> is_settled(open.size(), 0);
    parallel_for(open.size(), threads, [&](std::size_t i) {
      is_settled[i] = accept(works[open[i]->work], std::move(finals[i]), *open[i]) ? 1 : 0;
    });
    std::size_t i = 0;
    std::erase_if(open, [&](const Choice*) { return is_settled[i++] != 0; });
  }
}

void run_base(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  LevelFits level("base models", works, study.options.criteria.base, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    level.add(i, base_trials(works[i].candidates, works[i].table));
  }
  level.run(study.options.threads, progress, study.stages);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.base = level.candidates(i);
    for (const auto& [barred, why] : works[i].barred) {
      result.base[barred].objection = why;
      result.base[barred].is_examined = true;
    }
    choices.push_back({.work = i,
                       .candidates = &result.base,
                       .choose = [&result, &study, examine = curves_of(works[i], result.base)] {
                         return choose_base(result.base, study.options, examine);
                       }});
  }
  settle(works, level, study.options.threads, choices);
  for (Choice& choice : choices) {
    if (!choice.final) continue;
    ResponseStudy& result = works[choice.work].result;
    result.ols = std::move(choice.final);
    const Candidate& chosen = result.base[*choice.chosen];
    works[choice.work].compared = chosen.fit;
    if (chosen.objection.empty()) continue;
    result.doubts.push_back(fmt::format(
        "No base model has plausible curves; this is the best one. {}", chosen.objection));
  }
}

/// Tests against the first candidate; a fit that failed has no likelihood to test. If the first
/// one failed, no gain is significant.
void add_tests(std::vector<Candidate>& candidates) {
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    if (!candidates[i].fit.convergence.converged()) continue;
    candidates[i].test =
        nested_test(candidates[i].fit, candidates[0].fit).value_or(fit::NestedTest{});
  }
}

/// Tries the chosen sub-model without its intercept, as in some published models.
void run_without_intercept(std::vector<Work>& works,
                           Study& study,
                           const ProgressCallback& progress) {
  LevelFits level(
      "covariates alone", works, study.options.criteria.covariates, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    for (const Candidate& candidate : works[i].result.covariates) {
      if (!candidate.chosen) continue;
      if (auto trial = without_intercept(candidate, works[i].table)) level.add(i, {*trial});
    }
  }
  level.run(study.options.threads, progress, study.stages);
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    for (Candidate& candidate : level.candidates(i)) {
      // Not nested in level 1, so there is no likelihood-ratio test: the criterion alone decides.
      result.covariates.push_back(std::move(candidate));
      const std::size_t last = result.covariates.size() - 1;
      const auto choose = [&] {
        return choose_covariates(
            result.covariates, study.options, curves_of(works[i], result.covariates));
      };
      if (choose() != last) continue;
      const std::string objection =
          take_if_sound(works[i], level.result({.work = i, .position = 0}), result.with_covariates);
      if (objection.empty()) {
        works[i].compared = result.covariates[last].fit;
      } else {
        result.covariates[last].objection = objection;
        choose();
      }
    }
  }
}

void run_covariates(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  LevelFits level(
      "structural covariates", works, study.options.criteria.covariates, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    if (!works[i].result.ols || works[i].covariates.empty()) continue;
    level.add(i,
              covariate_trials(works[i].result.ols->fit,
                               works[i].covariates,
                               study.options.covariate_parameters,
                               works[i].table));
  }
  level.run(study.options.threads, progress, study.stages);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.covariates = level.candidates(i);
    result.with_covariates = result.ols;
    add_tests(result.covariates);
    choices.push_back(
        {.work = i,
         .candidates = &result.covariates,
         .choose = [&result, &study, examine = curves_of(works[i], result.covariates)] {
           return choose_covariates(result.covariates, study.options, examine);
         }});
  }
  settle(works, level, study.options.threads, choices);
  for (Choice& choice : choices) {
    if (!choice.final) continue;
    ResponseStudy& result = works[choice.work].result;
    result.with_covariates = std::move(choice.final);
    works[choice.work].compared = result.covariates[*choice.chosen].fit;
  }
  run_without_intercept(works, study, progress);
}

/// A boundary (singular) fit is the best mixed model only if there is no other.
void add_boundary_note(const fit::FittedModel& fit, std::vector<std::string>& notes) {
  if (!fit.convergence.has_boundary()) return;
  notes.push_back(
      fmt::format("Every mixed model is a boundary (singular) fit ({}): these plots do not support "
                  "more random effects.",
                  fmt::join(fit.convergence.boundary(), "; ")));
}

/// Reports why no mixed model is used, with the best of the rejected ones.
void doubt_mixed_models(ResponseStudy& result) {
  const auto best = std::ranges::min_element(result.random, {}, [](const Candidate& candidate) {
    return candidate.objection.empty() ? std::numeric_limits<int>::max() : candidate.rank;
  });
  if (best == result.random.end() || best->objection.empty()) return;
  result.doubts.push_back(
      fmt::format("With random effects on {}: {}", fmt::join(best->terms, ", "), best->objection));
}

Choice choice_of_random_effects(Work& work, std::size_t index, const StudyOptions& options) {
  ResponseStudy& result = work.result;
  return {.work = index,
          .candidates = &result.random,
          .choose = [&result,
                     &options,
                     examine = mixed_models_of(work, result.random, smaller_random_effects(work))] {
            return choose_random_effects(result.random, options, examine);
          }};
}

void run_random_effects(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  LevelFits level("random effects", works, study.options.criteria.random, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    const ResponseStudy& result = works[i].result;
    if (!result.with_covariates || !result.has_groups()) continue;
    level.add(i,
              random_effect_trials(result.with_covariates->fit,
                                   study.options.group,
                                   study.options.maximum_random_effects));
  }
  level.run(study.options.threads, progress, study.stages);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.random = level.candidates(i);
    if (works[i].compared) add_random_effect_tests(result.random, *works[i].compared);
    choices.push_back(choice_of_random_effects(works[i], i, study.options));
  }
  settle(works, level, study.options.threads, choices);
  for (Choice& choice : choices) {
    ResponseStudy& result = works[choice.work].result;
    if (choice.final) {
      result.nlme = std::move(choice.final);
    } else {
      doubt_mixed_models(result);
    }
  }
}

using TrialsOf = std::function<std::vector<Trial>(std::size_t work, const Candidate& candidate)>;

/// Random effects of several groupings, beside the candidates so far.
/// \param trials_of  a candidate; those that were candidates already are not fitted again
void run_further_terms(const std::string& name,
                       const TrialsOf& trials_of,
                       std::vector<Work>& works,
                       Study& study,
                       const ProgressCallback& progress) {
  LevelFits level(name, works, study.options.criteria.random, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    const std::vector<Candidate>& known = works[i].result.random;
    if (!works[i].result.nlme) continue;
    for (const Candidate& candidate : known) {
      std::vector<Trial> trials = trials_of(i, candidate);
      std::erase_if(trials, [&known](const Trial& trial) {
        return std::ranges::find(known, trial.terms, &Candidate::terms) != known.end();
      });
      level.add(i, std::move(trials));
    }
  }
  level.run(study.options.threads, progress, study.stages);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    std::vector<Candidate> nested = level.candidates(i);
    if (nested.empty()) continue;
    if (works[i].compared) add_random_effect_tests(nested, *works[i].compared);
    const std::size_t begin = result.random.size();
    std::ranges::move(nested, std::back_inserter(result.random));
    choices.push_back(choice_of_random_effects(works[i], i, study.options));
    choices.back().begin = begin;
  }
  settle(works, level, study.options.threads, choices);
  for (Choice& choice : choices) {
    if (choice.final) works[choice.work].result.nlme = std::move(choice.final);
  }
}

/// The trees' own effect on one coefficient, beside all candidates of the plots: without it,
/// differences between trees may have been taken for those of a coefficient between plots.
void run_tree_effects(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  fit::RandomEffects of_trees{.group = kTree, .within = {study.options.group}, .is_crossed = true};
  // Numbers of trees may begin again in each plot.
  if (study.options.group != "plot") of_trees.within.emplace_back("plot");
  for (Work& work : works) {
    if (!work.has_repeated_trees() || !work.is_sampled()) continue;
    work.result.notes.emplace_back(
        "Trees have no random effects of their own: a sample of the trees was compared, in which "
        "few are repeated (\"compared_trees\": 0 compares all).");
  }
  const auto trials_of = [&](std::size_t work, const Candidate& candidate) {
    const bool has_effects = works[work].has_repeated_trees() && !works[work].is_sampled() &&
                             candidate.fit.convergence.converged();
    return has_effects ? added_term_trials(candidate, of_trees, 1) : std::vector<Trial>();
  };
  run_further_terms("random effects of trees", trials_of, works, study, progress);
}

/// With repeated measurements: the trees, the periods of each plot, and the plots again, whose
/// effects were chosen without the others. Every combination would be too many fits. Beside the
/// variance between trees, that between periods may be too small to be found.
void run_repeated(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  const StudyOptions& options = study.options;
  if (options.period.empty()) return;
  run_tree_effects(works, study, progress);
  const fit::RandomEffects of_periods{.group = options.period, .within = {options.group}};
  const auto with_periods = [&](std::size_t /*work*/, const Candidate& candidate) {
    return candidate.chosen
               ? added_term_trials(candidate, of_periods, options.maximum_random_effects)
               : std::vector<Trial>();
  };
  run_further_terms("random effects of periods", with_periods, works, study, progress);
  const auto of_plots = [&](std::size_t /*work*/, const Candidate& candidate) {
    return candidate.chosen ? exchanged_term_trials(candidate, options.maximum_random_effects)
                            : std::vector<Trial>();
  };
  run_further_terms("random effects of plots again", of_plots, works, study, progress);
}

void note_boundary_fits(std::vector<Work>& works) {
  for (Work& work : works) {
    if (work.result.nlme) add_boundary_note(work.result.nlme->fit, work.result.notes);
  }
}

void run_variance(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  LevelFits level(
      "variance functions", works, study.options.criteria.variance, study.options.group);
  for (std::size_t i = 0; i < works.size(); ++i) {
    const ResponseStudy& result = works[i].result;
    for (const Candidate& candidate : result.random) {
      if (!candidate.chosen || !result.nlme) continue;
      std::vector<Trial> trials = variance_trials(candidate, study.options.variance_functions);
      level.add_known(i, trials.front(), candidate.fit, *result.nlme);
      trials.erase(trials.begin());
      level.add(i, std::move(trials));
    }
  }
  level.run(study.options.threads, progress, study.stages);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.variance = level.candidates(i);
    add_tests(result.variance);
    choices.push_back({.work = i,
                       .candidates = &result.variance,
                       .choose = [&result,
                                  &study,
                                  examine = mixed_models_of(
                                      works[i], result.variance, smaller_variances(result))] {
                         return choose_variance(result.variance, study.options, examine);
                       }});
  }
  settle(works, level, study.options.threads, choices);
  for (Choice& choice : choices) {
    if (choice.final) works[choice.work].result.nlme = std::move(choice.final);
  }
}

/// The mixed model with b = 0 predicts a typical plot, which may be far from the mean of all plots.
void run_plots_left_out(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  const std::string name = "plots left out";
  const auto start = std::chrono::steady_clock::now();
  StageTime stage{.name = name};
  for (const Work& work : works) stage.fits += left_out_fits(work.result);
  std::atomic<std::size_t> done{0};
  std::vector<StudiedTrees> studies;
  for (const Work& work : works) {
    studies.push_back({.result = work.result, .table = work.compared_trees()});
  }
  const auto left_out = cross_validate_levels(studies, study.options.threads, [&] {
    const std::size_t count = ++done;
    if (progress) progress(name, count, stage.fits);
  });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  stage.seconds = seconds.count();
  for (std::size_t i = 0; i < works.size(); ++i) {
    ResponseStudy& result = works[i].result;
    result.left_out = left_out[i];
    if (!result.left_out || !result.left_out->is_worse) continue;
    result.doubts.push_back(doubt_of(*result.left_out, unit_of(result.response)));
  }
  study.stages.push_back(stage);
}

void run_levels(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  for (Work& work : works) {
    work.plausibility.emplace(
        work.result.response, work.table, study.options.group, study.options.period);
  }
  run_base(works, study, progress);
  run_covariates(works, study, progress);
  run_random_effects(works, study, progress);
  run_repeated(works, study, progress);
  note_boundary_fits(works);
  run_variance(works, study, progress);
}

/// Whether mixed models were fitted and all of them rejected.
bool lacks_mixed_model(const ResponseStudy& result) {
  return !result.nlme && std::ranges::any_of(result.random, [](const Candidate& candidate) {
    return !candidate.objection.empty();
  });
}

/// Excludes the chosen base model; false if no other is left.
bool bar_base(Work& work) {
  bool has_other = false;
  for (std::size_t k = 0; k < work.result.base.size(); ++k) {
    const Candidate& candidate = work.result.base[k];
    if (candidate.chosen) {
      work.barred[k] = "All mixed models built on it were rejected. " +
                       (work.result.doubts.empty() ? "" : work.result.doubts.back());
    } else {
      has_other = has_other || (candidate.rank > 0 && candidate.objection.empty());
    }
  }
  return has_other;
}

/// The state of a result before its first level.
ResponseStudy without_levels(const ResponseStudy& result, std::vector<std::string> notes) {
  return {.species = result.species,
          .response = result.response,
          .rows = result.rows,
          .group = result.group,
          .period = result.period,
          .plots = result.plots,
          .notes = std::move(notes)};
}

/// Adds times and numbers of fits to those of stages with the same names.
void merge_stages(std::vector<StageTime>& stages, std::size_t begin) {
  for (std::size_t k = begin; k < stages.size(); ++k) {
    const auto known = std::ranges::find(stages, stages[k].name, &StageTime::name);
    known->seconds += stages[k].seconds;
    known->fits += stages[k].fits;
  }
  stages.resize(begin);
}

/// If no mixed model of the chosen base model can be used, the next base models are tried.
/// If none of them has one either, the first choice remains.
void run_other_bases(std::vector<Work>& works,
                     const std::vector<std::vector<std::string>>& notes,
                     Study& study,
                     const ProgressCallback& progress) {
  constexpr int kOthers = 3;
  std::map<std::size_t, ResponseStudy> first;
  for (int attempt = 0; attempt < kOthers; ++attempt) {
    std::vector<std::size_t> places;
    std::vector<Work> part;
    for (std::size_t i = 0; i < works.size(); ++i) {
      if (!lacks_mixed_model(works[i].result) || !bar_base(works[i])) continue;
      first.try_emplace(i, works[i].result);
      works[i].result = without_levels(works[i].result, notes[i]);
      places.push_back(i);
      part.push_back(std::move(works[i]));
    }
    if (places.empty()) break;
    const std::size_t begin = study.stages.size();
    run_levels(part, study, progress);
    merge_stages(study.stages, begin);
    for (std::size_t k = 0; k < places.size(); ++k) {
      part[k].plausibility.reset();  // refers to the table, which moves
      works[places[k]] = std::move(part[k]);
    }
  }
  for (auto& [i, result] : first) {
    if (!works[i].result.nlme) works[i].result = std::move(result);
  }
}

}  // namespace

void run_stages(std::vector<Work>& works, Study& study, const ProgressCallback& progress) {
  std::vector<std::vector<std::string>> notes;
  for (const Work& work : works) notes.push_back(work.result.notes);
  run_levels(works, study, progress);
  run_other_bases(works, notes, study, progress);
  run_plots_left_out(works, study, progress);
}

}  // namespace silvafit::study
