//! What methods cost: rates fitted to measured times.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::context::Context;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::method::{Algorithm, Energies, Method};
use crate::planner::{Effort, StageRate};

/// What an engine's work takes, ns; on engines of the CPU of one thread.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rates {
    /// Of one sample of the volume, by method in words.
    pub sample_ns: BTreeMap<String, f64>,
    /// Of one ray, whatever it meets.
    pub ray_ns: f64,
    /// Of one energy of one ray.
    pub energy_ns: f64,
    /// Of what is made of the rays in scenes with effects, which is done by threads of the CPU whatever casts them: by
    /// [`StageRate`] in words, of one thread. What is not there is taken from the built-in rates of `cpu`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub stage_ns: BTreeMap<String, f64>,
}

/// Largest rate, ns.
const MOST_NS: f64 = 1e9;

/// The rates of some engines on some machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Costs {
    /// Where they were measured.
    name: String,
    engines: BTreeMap<String, Rates>,
}

/// One measured time.
#[derive(Debug, Clone, Copy)]
pub struct Timed {
    /// What ran.
    pub method: Method,
    /// Energies of the sum.
    pub energies: usize,
    /// Seconds, times the number of threads on engines of the CPU.
    pub seconds: f64,
}

impl Rates {
    /// Fits rates to the times of one scene: Joseph with all and with few energies tell what an energy costs; every method
    /// has its own cost of a sample. What a ray costs is not told apart, and taken
    /// from `like`, scaled by how much slower Joseph is here.
    pub fn fitted(times: &[Timed], effort: &Effort, like: &Self) -> Self {
        let joseph = |few: bool| {
            times.iter().find(|t| {
                t.method == Method { energies: t.method.energies, ..Algorithm::Joseph.into() }
                    && few == matches!(t.method.energies, Energies::Few { .. })
            })
        };
        // How much slower than where `like` was measured.
        let slower =
            joseph(false).and_then(|all| Some(all.seconds / like.seconds(all.method, effort, all.energies)?));
        let slower = slower.unwrap_or(1.0);
        let energy_ns = match (joseph(false), joseph(true)) {
            (Some(all), Some(few)) if all.energies > few.energies && all.seconds > few.seconds => {
                1e9 * (all.seconds - few.seconds) / (effort.rays * (all.energies - few.energies) as f64)
            }
            // Less than what times can tell.
            _ => slower * like.energy_ns,
        };
        let stage_ns = like.stage_ns.iter().map(|(name, ns)| (name.clone(), slower * ns)).collect();
        let mut rates =
            Self { sample_ns: BTreeMap::new(), ray_ns: slower * like.ray_ns, energy_ns, stage_ns };
        for time in times {
            let of_rays = effort.rays * (rates.ray_ns + energy_ns * time.energies as f64);
            let left = 1e9 * time.seconds - of_rays;
            // What is not told apart is left to the built-in rates. The first of a kind counts.
            if left > 0.0 {
                let ns = left / effort.samples(time.method.algorithm).max(1.0);
                rates.sample_ns.entry(kind(time.method)).or_insert(ns);
            }
        }
        rates
    }

    /// Predicted time, s, of one thread.
    fn seconds(&self, method: Method, effort: &Effort, energies: usize) -> Option<f64> {
        let sample_ns = self.sample_ns.get(&kind(method))?;
        let of_rays = effort.rays * (self.ray_ns + self.energy_ns * energies as f64);
        Some(1e-9 * (sample_ns * effort.samples(method.algorithm) + of_rays))
    }
}

/// Methods of one kind take the same time per sample.
fn kind(method: Method) -> String {
    Method { energies: Energies::All, ..method }.to_string()
}

impl Default for Costs {
    /// As `drr tradeoff` measured them in the target case: `cuda` on an NVIDIA H100, `cpu` on 16 cores beside it. `metal` is
    /// `cuda` times 5.7, the estimate of `benches/README.md`, and has never been measured. Other engines are taken to be
    /// like `cpu`. What is made of rays in scenes with effects was measured on one thread of another machine, a virtual x86-64
    /// without wider vectors than SSE2, by `drr plan --measure --threads 1`.
    fn default() -> Self {
        let built_in = serde_json::from_str(include_str!("costs.json"));
        built_in.unwrap_or_else(|error| unreachable!("costs.json: {error}"))
    }
}

impl Costs {
    /// Rates of one engine.
    pub fn new(name: impl Into<String>, engine: Backend, rates: Rates) -> Self {
        Self { name: name.into(), engines: [(engine.name().to_owned(), rates)].into() }
    }

    /// Rates that [`Costs::to_json`] wrote.
    ///
    /// # Errors
    /// `InvalidArgument` when the text is not that, or a rate is negative or not finite.
    pub fn from_json(text: &str) -> Result<Self> {
        let valid = "what drr tradeoff --write-timings writes";
        let costs: Self =
            serde_json::from_str(text).map_err(|error| Error::invalid("timings", error, valid))?;
        for engine in costs.engines.keys() {
            if Backend::ALL.iter().all(|known| known.name() != engine) {
                return Err(Error::invalid("timings", engine, "engines that there are"));
            }
        }
        for (engine, rates) in &costs.engines {
            let named = rates.sample_ns.iter().map(|(kind, rate)| (kind.as_str(), rate, f64::MIN_POSITIVE));
            let stages = rates.stage_ns.iter().map(|(stage, rate)| (stage.as_str(), rate, 0.0));
            let named = named.chain(stages);
            let all = named.chain([("ray_ns", &rates.ray_ns, 0.0), ("energy_ns", &rates.energy_ns, 0.0)]);
            for (kind, rate, least) in all {
                if !(least..=MOST_NS).contains(rate) {
                    let valid = if least > 0.0 { "above 0 ns" } else { "at least 0 ns" };
                    return Err(Error::invalid(format!("timings.{engine}.{kind}"), rate, valid));
                }
            }
        }
        if costs.name.chars().any(char::is_control) {
            return Err(Error::invalid(
                "timings.name",
                costs.name.escape_debug(),
                "text without control characters",
            ));
        }
        Ok(costs)
    }

    /// As text.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| unreachable!("numbers and names: {error}"))
    }

    /// Where those of an engine were measured.
    pub fn name(&self, engine: Backend) -> &str {
        if self.rates(engine).is_some() { &self.name } else { "built-in rates" }
    }

    /// The rates of an engine, if they are known.
    pub fn rates(&self, engine: Backend) -> Option<&Rates> {
        self.engines.get(engine.name())
    }

    /// What a stage of a development takes on one thread, ns.
    pub(super) fn stage_ns(&self, engine: Backend, rate: StageRate) -> f64 {
        let own = |costs: &Self, engine| costs.rates(engine)?.stage_ns.get(rate.name()).copied();
        let here = own(self, engine).or_else(|| own(self, Backend::Cpu));
        here.or_else(|| own(&Self::default(), Backend::Cpu)).unwrap_or(0.0)
    }

    /// Predicted time of a method on the context's engine, s. What is not known is taken from the built-in rates, scaled by
    /// how much faster or slower Joseph's rule is here.
    pub fn seconds(&self, context: &Context, method: Method, effort: &Effort, energies: usize) -> f64 {
        let engine = context.backend();
        let own =
            |method: Method| self.rates(engine).and_then(|rates| rates.seconds(method, effort, energies));
        let built_in = || {
            let costs = Self::default();
            let rates = costs.rates(engine).or(costs.rates(Backend::Cpu));
            let known = |method| rates.and_then(|rates| rates.seconds(method, effort, energies));
            let joseph = Algorithm::Joseph.into();
            let scale = own(joseph).zip(known(joseph)).map_or(1.0, |(own, known)| own / known);
            known(method).or(known(joseph)).unwrap_or(f64::INFINITY) * scale
        };
        own(method).unwrap_or_else(built_in) / context.work_threads() as f64
    }
}
