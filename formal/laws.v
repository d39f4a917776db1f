(* A loop with a law of its own as a descriptor form, computed of the numbers of a file. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra.
From formal Require Export forms descriptor.
From formal Require mechanics.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.

Definition rows_of n m (f : nat -> nat -> Q) : numbers := mkseq (fun i => mkseq (f i) m) n.
Definition unit_of n : numbers := rows_of n n (fun i j => if i == j then one else zero).
Definition minus n m (a b : numbers) : numbers := rows_of n m (fun i j =>
  Qred (Qminus (entry a i j) (entry b i j))).
Definition product n k m (a b : numbers) : numbers := rows_of n m (fun i j =>
  foldr (fun l s => Qred (Qplus (Qmult (entry a i l) (entry b l j)) s)) zero (iota 0 k)).
(* [a, b; c, d], where a is n1 x m1 and d is n2 x m2. *)
Definition four n1 n2 m1 m2 (a b c d : numbers) : numbers :=
  rows_of (n1 + n2) (m1 + m2) (fun i j =>
    if (i < n1)%N then if (j < m1)%N then entry a i j else entry b i (j - m1)
    else if (j < m1)%N then entry c (i - n1) j else entry d (i - n1) (j - m1)).

(* M z'' + D z' + S z = B u with K_A z'' in u, x = (z, z', x3), x3' = U z. *)
Definition first_order n m p (U K_A : numbers) (v : mechanics.mechanics) : descriptor :=
  let M := minus n n (mechanics.M_ v) (product n m n (mechanics.B_ v) K_A) in
  let minus := minus n (n + (n + p)) [::] in
  Descriptor
    (four n (n + p) n (n + p) (unit_of n) [::] [::] (four n p n p M [::] [::] (unit_of p)))
    (four n (n + p) (n + (n + p)) 0 (four n 0 n (n + p) [::] (unit_of n) [::] [::]) [::]
      (four n p (n + (n + p)) 0
        (minus (four n 0 n (n + p) (mechanics.S_ v) (mechanics.D_ v) [::] [::])) [::] U [::])
      [::])
    (four n (n + p) m 0 [::] [::] (mechanics.B_ v) [::]).

(* q sensors see rows x, and E c' = A c + B rows x + (0, free), where the signals of
   of_sensors rows x + of_states c are y, and K y is (u, free). *)
Record controller := Controller { rows : numbers; own_E : numbers; own_A : numbers;
  own_B : numbers; of_sensors : numbers; of_states : numbers; gain : numbers }.
Definition with_law N m c f q (l : controller) (v : descriptor) : descriptor :=
  Descriptor
    (four N c N c (E_ v) [::] [::] (own_E l))
    (four N c N c (A_ v) [::] (product c q N (own_B l) (rows l)) (own_A l))
    (four N c m f (B_ v) [::] [::] (four (c - f) f 0 f [::] [::] [::] (unit_of f))).
Definition law_gain N m c f q y (l : controller) : numbers :=
  product (m + f) y (N + c) (gain l)
    (four y 0 N c (product y q N (of_sensors l) (rows l)) (of_states l) [::] [::]).
