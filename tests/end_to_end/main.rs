//! The command-line tool as its users meet it: one binary, each test in a scratch folder of its own.

mod bad_input;
mod browser;
mod determinism;
mod evidence;
mod masks;
mod plan_and_latency;
mod planner;
mod real_recordings;
mod recordings;
mod render;
mod report;
mod reproduce;
mod scratch;
mod volumes;
