//! One trial of 4,000 samples: written and read by the store (checks, digests, encodings), beside
//! the same numbers through parquet-rs with its default settings and no checks.
#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::print_stdout)] // a bench may panic

use arrow::array::{ArrayRef, Float64Array, RecordBatch};
use bytes::Bytes;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{
    RealFiles, Samples, Signal, Trial, read_footer, read_trial, trial_bytes, write_new,
};
use zwidth_study::TrialForm;

const SAMPLES: u32 = 4_000;
const SIGNALS: [Signal; 4] = [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::ForceEx];

fn trial() -> Trial {
    let t: Vec<f64> = (0..SAMPLES).map(|i| f64::from(i) * 1e-3).collect();
    let mut samples = Samples::default();
    for (signal, factor) in SIGNALS.into_iter().zip([0.0, 1.9, 2.3, 4.1]) {
        let values = t.iter().map(|t| if factor < 1.0 { *t } else { (t * factor).sin() * factor });
        samples.set(signal, values.collect());
    }
    let meta = zwidth_testing::meta(1, "hybrid");
    Trial { meta, file: Default::default(), samples }
}

fn plain_bytes(trial: &Trial) -> Vec<u8> {
    let column = |s: Signal| {
        (s.name(), Arc::new(Float64Array::from(trial.samples.get(s).unwrap().to_vec())) as ArrayRef)
    };
    let batch = RecordBatch::try_from_iter(SIGNALS.map(column)).unwrap();
    let mut bytes = Vec::new();
    let mut writer = ArrowWriter::try_new(&mut bytes, batch.schema(), None).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    bytes
}

fn store(c: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("participant=P01/session=S01/trial-001.parquet");
    let trial = trial();
    let bytes = trial_bytes(&trial, &TrialForm::default(), &path).unwrap();
    write_new(&RealFiles, &path, &bytes).unwrap();
    let plain = Bytes::from(plain_bytes(&trial));
    println!("bytes a trial: store {}, parquet-rs defaults {}", bytes.len(), plain.len());

    let mut group = c.benchmark_group("trial of 4,000 samples");
    group.throughput(Throughput::Elements(u64::from(SAMPLES)));
    group.bench_function("encode, store", |b| {
        b.iter(|| trial_bytes(&trial, &TrialForm::default(), Path::new("x")).unwrap())
    });
    group.bench_function("encode, parquet-rs defaults", |b| b.iter(|| plain_bytes(&trial)));
    group.bench_function("read, store, all signals", |b| {
        b.iter(|| read_trial(&path, Signal::all()).unwrap())
    });
    group.bench_function("read, store, two signals", |b| {
        b.iter(|| read_trial(&path, [Signal::Theta, Signal::ForceEx]).unwrap());
    });
    group.bench_function("read, parquet-rs", |b| {
        b.iter_batched(
            || plain.clone(),
            |bytes| {
                let reader =
                    ParquetRecordBatchReaderBuilder::try_new(bytes).unwrap().build().unwrap();
                reader.map(|batch| batch.unwrap().num_rows()).sum::<usize>()
            },
            BatchSize::SmallInput,
        );
    });
    group.bench_function("footer only, store", |b| b.iter(|| read_footer(&path).unwrap()));
    group.finish();
}

criterion_group!(benches, store);
criterion_main!(benches);
