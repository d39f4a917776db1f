(* The numbers of a proof file, and matrices of integers made of others. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export region.
From formal Require Import integers definite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* Numbers as a file writes them, and the integers d times them. *)
Definition numbers := seq (seq Q).
Definition whole (d : Z) (a : numbers) : entries := fun i j =>
  let q := nth (Qmake Z0 xH) (nth [::] a i) j in
  Z.div (Z.mul d (Qnum q)) (Zpos (Qden q)).
Definition is_whole (d : Z) (a : numbers) : bool := all (all (fun q =>
  Z.eqb (Z.modulo (Z.mul d (Qnum q)) (Zpos (Qden q))) Z0)) a.

Definition stack n (a b : entries) : entries := fun i j =>
  if (i < n)%N then a i j else b (i - n)%N j.
Definition side n (a b : entries) : entries := fun i j =>
  if (j < n)%N then a i j else b i (j - n)%N.
Definition diagonal (c : Z) : entries := fun i j => if i == j then c else Z0.
Definition none : entries := fun _ _ => Z0.
Definition times (c : Z) (a : entries) : entries := fun i j => Z.mul c (a i j).
Definition plus (a b : entries) : entries := fun i j => Z.add (a i j) (b i j).

Section Meaning.
Variable C : numClosedFieldType.

Definition phiQ (q : Q) : C := phi C (Qnum q) / phi C (Zpos (Qden q)).
Definition real n m (a : numbers) : 'M[C]_(n, m) :=
  \matrix_(i, j) phiQ (nth (Qmake Z0 xH) (nth [::] a i) j).

Lemma phi_pos q : phi C (Zpos q) != 0.
Proof. by apply: lt0r_neq0; exact: phi_gt0. Qed.

Lemma mx_whole n m d a : is_whole d a -> mx C n m (whole d a) = phi C d *: real n m a.
Proof.
move=> ok; apply/matrixP => i j; rewrite !mxE /whole.
set q := nth _ _ _; have : Z.eqb (Z.modulo (Z.mul d (Qnum q)) (Zpos (Qden q))) Z0.
  rewrite /q; case: (ltnP i (size a)) => hi; last first.
    by rewrite [nth [::] a i]nth_default // nth_nil /= Z.mul_0_r Z.mod_1_r.
  case: (ltnP j (size (nth [::] a i))) => hj; last first.
    by rewrite nth_default //= Z.mul_0_r Z.mod_1_r.
  by move/(all_nthP [::]): ok => /(_ i hi)/(all_nthP (Qmake Z0 xH))/(_ j hj).
move=> /Z.eqb_eq e; have {}e := proj2 (Z.div_exact _ (Zpos (Qden q)) ltac:(done)) e.
apply: (mulfI (phi_pos (Qden q))); rewrite -phiM -e phiM /phiQ.
by rewrite [RHS]mulrC mulrA mulfVK ?phi_pos.
Qed.

Lemma mx_stack n1 n2 m a b :
  mx C (n1 + n2) m (stack n1 a b) = col_mx (mx C n1 m a) (mx C n2 m b).
Proof.
apply/matrixP => i j; rewrite !mxE /stack; by case: (splitP i) => r ->; rewrite mxE ?addKn.
Qed.
Lemma mx_side n m1 m2 a b :
  mx C n (m1 + m2) (side m1 a b) = row_mx (mx C n m1 a) (mx C n m2 b).
Proof.
apply/matrixP => i j; rewrite !mxE /side; by case: (splitP j) => r ->; rewrite mxE ?addKn.
Qed.
Lemma mx_diagonal n c : mx C n n (diagonal c) = (phi C c)%:M.
Proof. by apply/matrixP => i j; rewrite !mxE /diagonal -val_eqE; case: eqP. Qed.
Lemma mx_none n m : mx C n m none = 0.
Proof. by apply/matrixP => i j; rewrite !mxE. Qed.
Lemma mx_times n m c a : mx C n m (times c a) = phi C c *: mx C n m a.
Proof. by apply/matrixP => i j; rewrite !mxE phiM. Qed.
Lemma mx_plus n m a b : mx C n m (plus a b) = mx C n m a + mx C n m b.
Proof. by apply/matrixP => i j; rewrite !mxE phiD. Qed.

Lemma phiN1 : phi C (Zneg xH) = -1.
Proof. exact: (phiN C (Zpos xH)). Qed.

Lemma det0_right n (A : 'M[C]_n) (x : 'cV[C]_n) : x != 0 -> A *m x = 0 -> \det A = 0.
Proof.
move=> x0 Ax; apply/eqP; rewrite -det_tr; apply/det0P; exists x^T.
  by rewrite trmx_eq0.
by rewrite -trmx_mul Ax trmx0.
Qed.

Lemma in_region_whole k g alpha beta s : Z.ltb 0 g -> is_whole g alpha -> is_whole g beta ->
  in_region (mx C k k (memo k k (whole g alpha))) (mx C k k (memo k k (whole g beta))) s ->
  in_region (real k k alpha) (real k k beta) s.
Proof.
move=> g0 wa wb inside v v0; have := inside v v0; rewrite !mx_memo !mx_whole //.
have -> : phi C g *: real k k alpha + s *: (phi C g *: real k k beta)
    + s^* *: (phi C g *: real k k beta)^T
  = phi C g *: (real k k alpha + s *: real k k beta + s^* *: (real k k beta)^T).
  by rewrite [(_ *: _)^T]linearZ /= !scalerDr !scalerA ![_ * phi C g]mulrC.
rewrite /herm /sesqui -scalemxAr -scalemxAl mxE pmulr_rlt0 //; exact: phi_gt0.
Qed.

Section Mean.
Variables (T : Type) (no : T) (vs : seq T).
Notation r := (size vs).
Variable w : 'I_r -> C.

(* The mean of the vertices' matrices X with the weights w. *)
Definition mean a b (X : T -> numbers) : 'M[C]_(a, b) :=
  \sum_i w i *: real a b (X (nth no vs i)).

Lemma sum_mean n1 n2 a (X : T -> numbers) (b : 'M[C]_(n2, a)) :
  \sum_i w i *: (real n1 n2 (X (nth no vs i)) *m b) = mean n1 n2 X *m b.
Proof. by rewrite mulmx_suml; apply: eq_bigr => i _; rewrite scalemxAl. Qed.
Lemma sum_col_mx n1 n2 (a : 'I_r -> 'cV[C]_n1) (b : 'I_r -> 'cV[C]_n2) :
  \sum_i w i *: col_mx (a i) (b i) = col_mx (\sum_i w i *: a i) (\sum_i w i *: b i).
Proof.
rewrite -[LHS]vsubmxK; congr col_mx; rewrite linear_sum; apply: eq_bigr => i _ /=.
  by rewrite linearZ /= col_mxKu.
by rewrite linearZ /= col_mxKd.
Qed.
Lemma sum_same n1 n2 (a : 'M[C]_(n1, n2)) : \sum_i w i = 1 -> \sum_i w i *: a = a.
Proof. by move=> w1; rewrite -scaler_suml w1 scale1r. Qed.
End Mean.
End Meaning.

(* Where a pole s may lie, in any field C. *)
Definition place := forall C : numClosedFieldType, C -> Prop.
Definition in_matrices k (alpha beta : numbers) : place := fun C s =>
  in_region (real C k k alpha) (real C k k beta) s.
Arguments in_matrices k alpha beta C s : clear implicits.

(* What is known of pencils s E - A: of all their means E is regular, and each pole s
   lies in the place R. *)
Definition decided N (R : place) (pencils : seq (entries * entries)) : Prop :=
  forall (C : numClosedFieldType) r (w : 'I_r -> C), size pencils = r ->
  (forall i, 0 <= w i) -> \sum_i w i = 1 ->
  \det (E_mean N pencils w) != 0 /\
  forall s, \det (s *: E_mean N pencils w - A_mean N pencils w) = 0 -> R C s.

Theorem pairs_sound N k alpha beta (g : Z) P wP wG pencils (R : place) :
  (forall C s, in_matrices k.+1 alpha beta C s -> R C s) ->
  [&& (0 < N)%N, Z.ltb 0 g, is_whole g alpha, is_whole g beta
    & lmis_hold N k.+1 (memo k.+1 k.+1 (whole g alpha)) (memo k.+1 k.+1 (whole g beta))
        (at_ P) pencils wP wG] ->
  decided N R pencils.
Proof.
move=> inside /and5P[N0 g0 wa wb ok] C r w size_r w0 w1; split.
  exact: (E_regular N0 ok size_r w0 w1 (ltn0Sn k)).
move=> s pole; apply: inside; apply: (in_region_whole g0 wa wb).
exact: (poles_in_region N0 ok size_r w0 w1 pole).
Qed.
