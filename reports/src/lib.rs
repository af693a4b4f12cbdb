//! Tables, charts, pictures, timelines and the self-contained HTML report: results made readable.
//!
//! Everything here returns text or bytes; only [`Outputs::commit`] writes files, and it writes all of
//! them or none.
//!
//! * [`Table`]: named columns, as CSV, JSON or text;
//! * [`Heatmap`], [`Histogram`], [`Waterfall`], [`LineChart`], [`BarChart`], [`ScatterChart`]: data with a method `svg`;
//! * [`png`], [`error_map()`], [`overlay`], [`annotated`], [`side_by_side`]: rendered images;
//! * [`TraceEvents`]: a timeline that Perfetto opens;
//! * [`Page`]: all of these in one HTML file that needs nothing else.
//!
//! # Charts
//!
//! Drawn with plotters, as SVG whose letters are those of the reader's system: only their width is
//! estimated for the layout. A style sheet exchanges colours where the reader prefers dark, so that one
//! file suits both.

mod axes;
mod bars;
mod colormap;
mod colour_bar;
mod decades;
mod error;
mod error_map;
mod frame;
mod heatmap;
mod histogram;
mod lines;
mod number;
mod outline;
mod outputs;
mod page;
#[cfg(feature = "parquet")]
mod parquet;
mod picture;
mod rows;
mod scatter;
mod strips;
mod svg;
mod table;
mod table_reader;
mod table_writer;
mod theme;
mod ticked;
mod trace_events;
mod waterfall;

pub use bars::{BarChart, BarSeries};
pub use colormap::ColourMap;
pub use error::ReportError;
pub use error_map::{ERROR_FULL_SCALE, ErrorMap, error_map};
pub use heatmap::{ColourScale, HeatCell, Heatmap};
pub use histogram::{Histogram, HistogramSeries};
pub use lines::{LineChart, LineSeries};
pub use outline::{Outline, annotated, overlay};
pub use outputs::Outputs;
pub use page::Page;
#[cfg(feature = "parquet")]
pub use parquet::ColumnType;
pub use picture::{image_digest, png, shrink, side_by_side};
pub use scatter::{ScatterChart, ScatterSeries};
pub use strips::{Strip, Strips};
pub use table::{Cell, Table};
pub use table_writer::{TableDigest, TableWriter, TextLayout, csv_line};
pub use trace_events::{TraceEvents, Track};
pub use waterfall::{Waterfall, WaterfallStage};
